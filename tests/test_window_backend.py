"""MPLBACKEND names a backend for windows that matplotlib may not know: pictures in files are drawn all the same."""

import ast
import os

import house
import pytest
from scenes import python
from series import written

UNKNOWN = "tests-name-no-such-backend"
DRAWS = {
    "panels": "from tcontact.show.plots import panels; t = np.arange(3.0);"
    " panels(file, {('path', 'm'): {'here': (t, t)}})",
    "gap": "from tcontact.show.plots import gap; t = np.arange(3.0);"
    " gap(file, dict(time=t, gap_min=t, contact_nodes=t))",
    "views": "from tcontact import box_mesh; box_mesh((1, 1, 1), (1, 1, 1)).plot().figure.savefig(file)",
    "colours": "from tcontact.show.render.colours import colour_map; colour_map('body', 'coolwarm')",
    "font": "from tcontact.show.render.labels import font; font(9)",
    "study": "from tcontact.lab.study.figure import draw; draw(file, dict(rows=[], error='error'))",
    "bench": "from tcontact.lab.bench.chart import draw; draw(file, dict(rows=[]))",
    "layers": "from tcontact.friction_layer.figures import yield_limits; yield_limits(file, dict(one=[]))",
    "quick": "from tcontact.commands.quick_import import load_matplotlib; load_matplotlib()",
}


@pytest.mark.parametrize("draws", DRAWS)
def test_an_unknown_backend_does_not_keep_pictures_from_being_drawn(draws, tmp_path):
    """The variable is there for the programs that this one starts."""
    code = "import os, pathlib; import numpy as np; file = pathlib.Path(sys.argv[1])\n" + DRAWS[draws]
    code += "\nprint(os.environ['MPLBACKEND'])"
    done = python(code, tmp_path / "picture.png", env=os.environ | {"MPLBACKEND": UNKNOWN})
    assert (done.returncode, done.stdout.strip()) == (0, UNKNOWN), done.stderr


def test_commands_draw_whatever_the_backend(tmp_path):
    """Jupyter names its own backend, which the environment of a program need not have."""
    path = written(tmp_path)
    code = "from tcontact.commands.cli import main; render = 'render', sys.argv[1], '--time', '0', '--size', '160x160'"
    code += "\nsys.exit(main(render) or main(['report', sys.argv[1]]))"
    done = python(code, path, env=os.environ | {"MPLBACKEND": UNKNOWN})
    assert done.returncode == 0, done.stderr


def test_a_backend_that_there_is_stays_the_choice_of_the_user():
    code = "from tcontact.base.window_backend import import_matplotlib; import_matplotlib(); import matplotlib as mpl"
    done = python(code + "; print(mpl.rcParams['backend'])", env=os.environ | {"MPLBACKEND": "svg"})
    assert done.stdout.strip() == "svg", done.stderr


def test_matplotlib_is_imported_in_one_way_alone():
    """Every function that imports from it calls `import_matplotlib` first."""
    wrong = []
    for name, path in house.MODULES.items():
        if name == "tcontact.base.window_backend":
            continue
        for function in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(function, ast.FunctionDef):
                continue
            calls = [node.lineno for node in ast.walk(function) if isinstance(node, ast.Call)
                     and ast.unparse(node.func) == "import_matplotlib"]  # fmt: skip
            for node in ast.walk(function):
                names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
                names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
                if any(one.partition(".")[0] == "matplotlib" for one in names) and min([*calls, 10**9]) > node.lineno:
                    wrong.append(f"{name}, line {node.lineno}")
    assert not wrong
