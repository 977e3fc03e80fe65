"""Values of every sort, most of them wrong in most places."""

import numpy as np
from hypothesis import strategies as st

import tcontact as tc

MESH = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
MAT = tc.NeoHookean(1e7, 0.3, 1000.0)


class Odd:
    """Answers nothing that is asked of it."""

    def __repr__(self):
        return "Odd()"

    def __bool__(self):
        raise RuntimeError("neither")

    def __array__(self, dtype=None, copy=None):
        raise RuntimeError("no array")


class Speechless:
    def __repr__(self):
        raise RuntimeError("no words")


def boom(*_):
    raise KeyError("boom")


CALLABLES = [
    boom,
    lambda *_: None,
    lambda *_: "text",
    lambda x: np.zeros(7),
    lambda x: np.full(np.shape(x), np.nan),
    lambda x: [[1, 2], [3]],
    lambda x: x,
    lambda: 0,
    int,
    lambda x: np.full((3,), 1e300),
    lambda x: Odd(),
]
SMALL = [0, 1, -1, 2, 3, 0.0, -0.0, 0.3, 0.5, 1e-3, 1.0, 2.5, -1.5, 1e7]
EXTREME = [np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324, 1e200, 10**400, -(10**400), 2**31, 2**63, 2**64, 1e150]
NUMPY = [
    np.float64(0.3),
    np.float32(0.3),
    np.int64(2),
    np.uint8(3),
    np.bool_(True),
    np.array(1.0),
    np.array([1.0]),
    np.zeros((0, 3)),
    np.zeros(3),
    np.ones((27, 3)),
    np.ones((2, 2, 2, 2)),
    np.array(["a", "b", "c"]),
    np.array([None, 1, 2], dtype=object),
    np.array([1j, 2, 3]),
    np.datetime64("2020-01-01"),
    np.ma.masked,
    np.full(3, np.nan),
    np.arange(24).reshape(3, 8),
]
WORDS = ["", "x", "xyz", "zmin", "auto", "full", "none", "cpu", "\0", "é" * 300, "[1, 2]", "nan", "1e3", "a/b"]
OTHERS = [
    None,
    True,
    False,
    b"zmin",
    1j,
    object(),
    Odd(),
    range(3),
    {},
    {"a": 1},
    set(),
    (),
    [],
    int,
    [[]],
]
OBJECTS = [MESH, MAT, tc.Plane(), tc.Support("xmin", "x"), tc.Coulomb(0.1), tc.MassDamping(1.0), tc.CentralDifference()]
LISTS = [
    (0, 0, 1),
    [0.0, 0.0, -1.0],
    (1, 2),
    [1, 2, 3, 4],
    [[1, 2], [3]],
    [None] * 3,
    ["a", 1, 2],
    (2, 2, 2),
    [True] * 3,
]
SCALARS = SMALL + EXTREME + NUMPY + WORDS + OTHERS + OBJECTS + LISTS + CALLABLES
ANY = st.one_of(
    st.sampled_from(SCALARS),
    st.floats(),
    st.integers(),
    st.text(max_size=5),
    st.lists(st.one_of(st.floats(), st.sampled_from(SMALL)), min_size=3, max_size=3),
    st.recursive(
        st.sampled_from(SCALARS),
        lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=3), inner, max_size=2)),
        max_leaves=6,
    ),
)
