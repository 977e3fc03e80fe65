"""The house: what may import what, what documents itself, how long a file may grow, what a package contains."""

from __future__ import annotations

import ast
import inspect
import re
import subprocess
import sys
from pathlib import Path

import house
import pytest

import tcontact
from tcontact.base import moved

ROOT = Path(__file__).resolve().parent.parent
SOURCES = sorted(path for place in ("tcontact", "kernels", "cases") for path in (ROOT / place).rglob("*.py"))
KERNELS = [path for path in SOURCES if (ROOT / "kernels") in path.parents and path.name != "__init__.py"]
HEAVY = {"taichi", "matplotlib", "PIL", "rich", "unittest", "asyncio"}


def relative(path: Path) -> str:
    """Path below the root, to name a test."""
    return path.relative_to(ROOT).as_posix()


def modules_after(code: str) -> set[str]:
    """Top-level modules in memory after running code in a new interpreter."""
    report = (
        f"import sys\n{code}\nprint('modules', *{{name.partition('.')[0] for name in sys.modules}}, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", report], cwd=ROOT, capture_output=True, text=True, check=True)
    return set(done.stderr.split("modules")[-1].split())


def test_import_is_light():
    assert not modules_after("import tcontact") & HEAVY
    public = (
        "import tcontact as tc; [getattr(tc, name) for name in tc.__all__ if name not in ('simulate', 'render_frames')]"
    )
    assert not modules_after(public) & {"taichi", "matplotlib"}


def test_listing_the_cases_is_light():
    found = modules_after("from tcontact.commands.cli import main; main(['list', '-v'])")
    assert not found & {"taichi", "matplotlib"}


def test_building_a_scene_is_light():
    assert "taichi" not in modules_after("from tcontact.cases import cube_impact; cube_impact.scene(cells=2)")


@pytest.mark.parametrize("path", KERNELS, ids=relative)
def test_kernels_import_relatively_and_say_what_they_compute(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    assert ast.get_docstring(tree), "a kernel file opens with its formula"
    for node in ast.walk(tree):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and node.level == 0:
            names.append(node.module or "")
        for name in names:
            assert name.partition(".")[0] not in ("tcontact", "kernels", "cases"), (
                f"line {node.lineno}: import relatively"
            )
        if isinstance(node, ast.ImportFrom):
            depth = len(path.relative_to(ROOT / "kernels").parts)
            assert node.level <= depth, f"line {node.lineno}: kernels know nothing of the package around them"


def test_the_static_solve_does_not_know_what_an_obstacle_is():
    """No module of the static solve imports one of the obstacles, not even through others."""
    targets: dict[str, set[str]] = {}
    for arrow in house.arrows():
        targets.setdefault(arrow.start, set()).add(arrow.end)
    known = {name for name in targets if name.startswith("tcontact.kernels.static.")}
    assert len(known) > 8
    waiting = list(known)
    while waiting:
        new = targets.get(waiting.pop(), set()) - known
        known |= new
        waiting += new
    assert "tcontact.kernels.contact.constraint_rows" in known
    assert not {name for name in known if "obstacle" in name}


@pytest.mark.parametrize("path", KERNELS, ids=relative)
def test_kernels_hold_no_state(path):
    """At module level no field, and no list, dict or set but in capitals; nowhere a `global`."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        assert not isinstance(node, ast.Global), f"line {node.lineno}: a global is state"
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = [ast.unparse(target) for target in targets]
            value = node.value
            changing = isinstance(value, ast.List | ast.Dict | ast.Set | ast.ListComp | ast.DictComp)
            changing = changing and not all(name.isupper() for name in names)
            if isinstance(value, ast.Call):
                changing = ast.unparse(value.func) in ("ti.field", "ti.ndarray", "ti.Vector.field", "ti.Matrix.field")
            assert not changing, f"line {node.lineno}: {names} can change"


def test_every_section_that_is_cited_is_in_the_documentation():
    """METHOD n stands for docs/METHOD.md."""
    sections = set(re.findall(r"^## (\d)\.", (ROOT / "docs" / "METHOD.md").read_text(encoding="utf-8"), flags=re.M))
    cited = 0
    for path in [*SOURCES, *(ROOT / "tests").rglob("*.py")]:
        text = path.read_text(encoding="utf-8")
        found = re.findall(r"\bMETHOD (\d)", text)
        assert set(found) <= sections, relative(path)
        cited += len(found)
    assert cited > 50


@pytest.mark.parametrize("path", SOURCES, ids=relative)
def test_files_stay_small(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 450


@pytest.mark.parametrize("path", SOURCES, ids=relative)
def test_files_say_what_they_are_about(path):
    text = path.read_text(encoding="utf-8")
    assert not text.strip() or ast.get_docstring(ast.parse(text)), "a file opens with a docstring"


def test_public_names_are_documented():
    for name in tcontact.__all__:
        public = getattr(tcontact, name)
        if not (inspect.isclass(public) or inspect.isfunction(public)):
            continue
        assert inspect.getdoc(public), f"{name} has no docstring"
        if inspect.isclass(public):
            for part, member in vars(public).items():
                if not part.startswith("_") and (inspect.isfunction(member) or isinstance(member, property)):
                    assert inspect.getdoc(member), f"{name}.{part} has no docstring"


def test_every_package_is_packaged():
    tomllib = pytest.importorskip("tomllib")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    listed = set(project["tool"]["setuptools"]["packages"])
    found = set()
    for path in SOURCES:
        parts = path.parent.relative_to(ROOT).parts
        found.add(".".join(parts if parts[0] == "tcontact" else ("tcontact", *parts)))
    assert listed == found


def test_version_is_stated_once():
    tomllib = pytest.importorskip("tomllib")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert "version" in project["dynamic"]
    assert tcontact.__version__.count(".") == 2


# The rooms of the house: which stand above which is told in house.ROOMS and house.KERNEL_ROOMS, and nowhere else


ARROWS = house.arrows()


def test_every_module_stands_in_a_room():
    assert {house.room(name) for name in house.MODULES} == set(house.ROOMS)
    kernels = {house.kernel_room(name) for name in house.MODULES if house.room(name) == "kernels"}
    assert kernels - {""} == set(house.KERNEL_ROOMS)
    assert len(house.ROOMS) <= 20


def test_imports_go_down():
    assert house.upward(ARROWS) == []


def test_imports_make_no_circles():
    own = [(arrow.start, arrow.end) for arrow in ARROWS if arrow.end.partition(".")[0] == "tcontact"]
    assert house.circles(own) == []
    rooms = [(house.room(start), house.room(end)) for start, end in own]
    assert house.circles((start, end) for start, end in rooms if start != end) == []


def test_imports_in_functions_are_of_what_is_heavy():
    assert house.needless(ARROWS) == []


@pytest.mark.parametrize(
    ("name", "line", "finds"),
    [
        ("tcontact.mesh.box", "from ..run.loop import Run\n", house.upward),
        ("tcontact.kernels.contact.friction", "from ..static.sweeps import sweep\n", house.upward),
        ("tcontact.mesh.box", "def later():\n    from ..run.loop import Run\n", house.upward),
        ("tcontact.results.report", "def later():\n    from . import checks\n", house.needless),
        (
            "tcontact.mesh.mesh",
            "from .box import box_mesh\n",
            lambda found: house.circles((arrow.start, arrow.end) for arrow in found),
        ),
    ],
)
def test_a_wrong_import_is_seen(name, line, finds):
    text = house.MODULES[name].read_text(encoding="utf-8")
    assert len(finds(house.arrows({name: f"{text}\n{line}"}))) > len(finds(ARROWS))


def test_no_module_is_called_like_a_function_that_a_package_exports():
    """Importing the module would take the place of the function."""
    packages = {name: path for name, path in house.MODULES.items() if path.name == "__init__.py"}
    public = {name for name in tcontact.__all__ if inspect.isfunction(getattr(tcontact, name))}
    assert not [name for name in house.MODULES if name.rpartition(".")[2] in public]
    for package, path in packages.items():
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                for alias in node.names:
                    bound = alias.asname or alias.name
                    assert f"{package}.{bound}" not in house.MODULES, f"{package} exports {bound}, which is a module"


OLD_NAMES = """
import importlib, sys, warnings
from operator import attrgetter
import tcontact as tc
from tcontact.base import moved
functions = {name: attrgetter(name)(tc) for name in moved.FUNCTIONS}
from tcontact.friction_layer.solve import solve
assert solve is functions["friction_layer.solve"]
for old in [*moved.KEPT, *moved.MOVED]:
    seen = f"tcontact.{old}" in sys.modules and old not in moved.FUNCTIONS
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        module = importlib.import_module(f"tcontact.{old}")
        new = importlib.import_module(f"tcontact.{moved.destination(old)}")
        if old in moved.FUNCTIONS:
            name = old.rpartition(".")[2]
            assert getattr(module, name) is getattr(new, name)
        else:
            assert module is new and module.__spec__.name == module.__name__, old
    told = [warning for warning in caught if "the old name goes" in str(warning.message)]
    assert seen or bool(told) == (old.split(".")[0] not in moved.KEPT), old
assert functions == {name: attrgetter(name)(tc) for name in moved.FUNCTIONS}
from tcontact.obstacles.motion import Motion
import tcontact.scene.obstacles.motion
assert Motion is tcontact.scene.obstacles.motion.Motion
"""


def test_old_names_of_modules_lead_to_the_modules():
    modules_after(OLD_NAMES)


def test_old_names_hide_no_module_of_today():
    """Old names are looked for first."""
    present = {name.partition(".")[2] for name in house.MODULES}
    assert not present & {*moved.MOVED, *moved.KEPT}
    assert {moved.destination(old) for old in moved.MOVED} <= present


def test_an_old_attribute_warns_and_works():
    material = tcontact.NeoHookean(1e6, 0.3, 1000.0)
    with pytest.warns(DeprecationWarning, match="parameters"):
        assert material.moduli == material.parameters
