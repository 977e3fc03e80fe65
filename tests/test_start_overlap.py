"""Bodies of a pair that overlap at the start are refused wherever no row holds them; what touches or fits is not."""

import numpy as np
import pytest
from pair_scenes import soft

import tcontact as tc
from tcontact.contact.pairs.pair_contact import check_starts
from tcontact.mesh.hull_overlap import hulls_of, overlaps

CONTACTS = {"massless": tc.MasslessContact("full"), "penalty": tc.PenaltyContact(3.0)}
TURN = ((1.0, 2.0, 3.0), 0.5)
PAIR = [tc.Pair("a", "b")]


def scene(one, other, contact="massless", pairs=None, sets=("auto", "auto"), **options):
    """Return two bodies "a" and "b" of these meshes as a scene, a pair by name unless `pairs` says otherwise."""
    bodies = [
        tc.Body(mesh, soft(), contact=faces, name=name, displacement=options.pop(f"displaced_{name}", None))
        for mesh, faces, name in zip((one, other), sets, "ab", strict=True)
    ]
    return tc.Scene(bodies, duration=0.01, pairs=PAIR if pairs is None else pairs, contact=CONTACTS[contact], **options)


def cubes(offset, cells, kind="hex8"):
    """Return two cubes of edge 0.1, the second one moved."""
    return [tc.box_mesh((0.1,) * 3, (cells,) * 3, kind, origin=origin) for origin in ((0, 0, 0), offset)]


def started(made):
    """Return whether the start of a scene is accepted."""
    check_starts(tc.plan(made).domains, [body.initial_displacement for body in made.bodies])
    return True


def cut(mesh, kept):
    """Return the mesh of the cells whose centres [m, 3] `kept` chooses."""
    return mesh.with_sets(cell_sets={"kept": np.flatnonzero(kept(mesh.cell_centres()))}).part("kept")


@pytest.mark.parametrize("pairs", ["auto", PAIR], ids=["auto", "named"])
@pytest.mark.parametrize(
    ("offset", "cells", "depth"),
    [
        ((0.08, 0.03, 0.09), 4, "0.01"),
        ((0.05, 0.0, 0.05), 3, "0.05"),
        ((0.05, 0.0, 0.0), 3, "0.05"),
        ((0.0, 0.0, 0.05), 3, "0.05"),
        ((0.05, 0.0, 0.05), 2, "0.05"),
        ((0.05, 0.02, 0.05), 3, "0.05"),
        ((0.05, 0.05, 0.05), 3, "0.05"),
    ],
)
def test_cubes_that_overlap_by_edges_corners_and_flush_sides_are_refused_with_the_depth(offset, cells, depth, pairs):
    """Their faces either do not look at each other or lie further apart than rows reach."""
    with pytest.raises(tc.InputError, match=rf"Scene.bodies = 'a': it starts {depth} m inside b near .* move them"):
        tc.simulate(scene(*cubes(offset, cells), pairs=pairs))


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
@pytest.mark.parametrize(("offset", "cells"), [((0.0, 0.0, 0.0), 1), ((0.05, 0.0, 0.05), 3), ((0.0, 0.0, 0.05), 2)])
def test_the_same_with_a_penalty_and_every_kind_of_cell(kind, offset, cells):
    with pytest.raises(tc.InputError, match=r"it starts (0\.1|0\.05) m inside b near"):
        started(scene(*cubes(offset, cells, kind), "penalty"))


@pytest.mark.parametrize("contact", CONTACTS)
def test_bars_that_cross_are_refused_though_no_node_of_either_is_inside_the_other(contact):
    """They are as high as each other, and the edges of one pass through the sides of the other."""
    one = tc.box_mesh((1.0, 0.1, 0.1), (6, 2, 2), origin=(-0.52, -0.05, 0.0))
    other = tc.box_mesh((0.1, 1.0, 0.1), (2, 6, 2), origin=(-0.05, -0.48, 0.0))
    faces = ("ymin", "ymax", "zmax"), ("xmin", "xmax", "zmin")
    with pytest.raises(tc.InputError, match="inside"):
        started(scene(one.rotated(TURN), other.rotated(TURN), contact, sets=faces))


def test_a_body_within_another_one_is_refused():
    """No surface cuts the other: a node decides, 0.45 below the surface."""
    small = tc.box_mesh((0.1,) * 3, (2, 2, 2), origin=(-0.05,) * 3)
    large = tc.box_mesh((1, 1, 1), (6, 6, 6), origin=(-0.5,) * 3)
    with pytest.raises(tc.InputError, match=r"it starts 0\.45 m inside"):
        started(scene(large, small, "penalty", sets=("zmax", "zmin")))


@pytest.mark.parametrize("contact", CONTACTS)
def test_a_row_on_one_side_does_not_excuse_an_overlap_on_another(contact):
    """The block stands on the floor of an L and half a cell in its wall; at the wall itself it is accepted."""
    corner = cut(tc.box_mesh((2, 2, 1), (8, 8, 4)), lambda at: (at[:, 0] < 1.0) | (at[:, 1] < 1.0))
    for turned in (lambda mesh: mesh, lambda mesh: mesh.rotated(TURN)):
        block = tc.box_mesh((0.9, 0.9, 0.8), (3, 3, 2), origin=(1.0, 1.0, 0.1))
        assert started(scene(turned(corner), turned(block), contact))
        with pytest.raises(tc.InputError, match=r"it starts 0\.1\d* m inside"):
            started(scene(turned(corner), turned(block.translated((-0.12, 0.0, 0.0))), contact))


@pytest.mark.parametrize("contact", CONTACTS)
def test_displaced_bodies_that_overlap_are_refused(contact):
    meshes = cubes((0.35, 0.0, 0.05), 3)
    with pytest.raises(tc.InputError, match=r"it starts 0\.05 m inside"):
        tc.simulate(scene(*meshes, contact, displaced_b=(-0.3, 0.0, 0.0)))


def test_a_result_that_leaves_bodies_overlapping_is_no_start_for_a_pair():
    one, other = cubes((0.15, 0.0, 0.05), 3)
    bodies = [tc.Body(one, soft(), contact="auto", name="a"),
              tc.Body(other, soft(), (-1.0, 0.0, 0.0), contact="auto", name="b")]  # fmt: skip
    with pytest.warns(tc.OverlapWarning):
        first = tc.simulate(tc.Scene(bodies, duration=0.1, pairs=None))
    with pytest.raises(tc.InputError, match=r"it starts 0\.05\d* m inside"):
        tc.simulate(tc.Scene(bodies, duration=0.1, pairs=PAIR), initial=first)


@pytest.mark.parametrize("contact", CONTACTS)
def test_what_touches_or_interlocks_is_accepted(contact):
    """Cubes at a face, an edge and a corner, flush or not, and teeth in gaps of their size, along axes and turned."""
    comb = tc.box_mesh((3, 1, 1), (12, 4, 4))
    teeth = cut(comb, lambda at: (at[:, 2] < 0.5) | (np.floor(at[:, 0] / 0.5) % 2 == 0))
    gaps = cut(comb, lambda at: (at[:, 2] > 0.5) | (np.floor(at[:, 0] / 0.5) % 2 == 1)).translated((0, 0, 0.5))
    scenes = [cubes((0.1 * (i > 0), 0.1 * (i > 1), 0.1), 3) for i in range(3)]
    scenes += [cubes((0.03, 0.01, 0.1), 4), [teeth, gaps]]
    for one, other in scenes:
        assert started(scene(one, other, contact))
        assert started(scene(one.rotated(TURN), other.rotated(TURN), contact))
    with pytest.raises(tc.InputError, match="inside"):
        started(scene(teeth, gaps.translated((0.05, 0.0, 0.0)), contact))


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
@pytest.mark.parametrize("gap", ["as-meshed", "closed"])
def test_facets_of_rings_that_fit_are_accepted(kind, gap):
    """Corners of one stand in the flat faces of the other by up to the sagitta, as far as they are apart elsewhere."""
    inner = tc.ring_mesh(0.5, 1.0, 0.2, 8, kind, layers=2, start=-0.1)
    outer = tc.ring_mesh(1.0, 1.5, 0.2, 12, kind, layers=2)
    pairs = [tc.Pair("a", "b", slave="a", initial_gap=gap)]
    assert started(scene(inner, outer, pairs=pairs, sets=("outer", "inner")))


def test_hulls_overlap_by_the_depth_of_the_origin_in_the_hull_of_their_differences():
    """Random tetrahedra are judged by a convex hull in three dimensions too, which knows of no axes."""
    from scipy.spatial import ConvexHull

    generator = np.random.default_rng(4)
    every = np.ones((1, 4), dtype=bool)
    met = 0
    for _ in range(60):
        one, other = generator.normal(size=(2, 4, 3))
        found = overlaps(*(hulls_of([("tet4", points[None], every)]) for points in (one, other)), 0.0)
        depth = -ConvexHull((one[:, None] - other).reshape(-1, 3)).equations[:, 3].max()
        met += len(found.pairs)
        assert len(found.pairs) == int(depth > 0.0)
        assert found.depth == pytest.approx([depth] * len(found.pairs), abs=1e-12)
    assert 10 < met < 50
