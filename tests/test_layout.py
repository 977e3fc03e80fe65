"""The house: what may import what, what documents itself, how long a file may grow, what a package contains."""

from __future__ import annotations

import ast
import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

import tcontact

ROOT = Path(__file__).resolve().parent.parent
SOURCES = sorted(path for place in ("tcontact", "kernels", "cases") for path in (ROOT / place).rglob("*.py"))
KERNELS = [path for path in SOURCES if (ROOT / "kernels") in path.parents and path.name != "__init__.py"]
HEAVY = {"taichi", "matplotlib", "PIL", "rich"}


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
    found = modules_after("from tcontact.cli import main; main(['list', '-v'])")
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


STATIC_SOLVE = [path for path in KERNELS if path.stem.startswith("static_") or path.stem == "sweeps"]


@pytest.mark.parametrize("path", STATIC_SOLVE, ids=relative)
def test_the_static_solve_does_not_know_what_an_obstacle_is(path):
    """No module of the static solve imports one of the obstacles, not even through others."""
    known, waiting = set(), [path]
    while waiting:
        for node in ast.walk(ast.parse(waiting.pop().read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level == 1:
                names = [node.module] if node.module else [alias.name for alias in node.names]
                places = {name: ROOT / "kernels" / name.replace(".", "/") for name in set(names) - known}
                files = [
                    place / "__init__.py" if place.is_dir() else place.with_suffix(".py") for place in places.values()
                ]
                waiting += [file for file in files if file.exists()]  # else an object of the package
                known |= set(names)
    assert "constraint_rows" in known or path.stem == "static_control"
    assert not {name for name in known if name.startswith("obstacle")}


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
