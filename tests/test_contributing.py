"""CONTRIBUTING names files and objects that exist, and the parts explain themselves where it says they do."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import house
import pytest

import tcontact as tc

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_every_file_that_a_recipe_names_exists():
    named = set(re.findall(r"`((?:tcontact|kernels|cases|tests|docs|\.ci)/[\w./]+)(?:::\w+)?`", TEXT))
    assert len(named) > 15
    for name in named:
        assert "my_" in name or (ROOT / name).exists(), name


def test_every_object_that_a_recipe_names_is_there():
    pairs = re.findall(r"`([\w/.]+\.py)::(\w+)`", TEXT)
    pairs += [("tcontact/planning/planning.py", name) for name in re.findall(r"`Plan\.(\w+)`", TEXT)]
    pairs += [("tcontact/planning/body_plan.py", name) for name in re.findall(r"`BodyPlan\.(\w+)`", TEXT)]
    pairs += [("tcontact/schemes/implicit/scheme.py", name) for name in re.findall(r"`ImplicitScheme\.(\w+)`", TEXT)]
    pairs += [
        ("kernels/materials/law.py", "Law"),
        ("kernels/materials/law.py", "tangent_form"),
        ("kernels/materials/law.py", "StepLaw"),
        ("tcontact/scene/materials.py", "LAWS"),
        ("tcontact/schemes/__init__.py", "IMPLICIT"),
        ("tests/test_implicit_tangents.py", "SCHEMES"),
    ]
    assert len(pairs) > 8
    for file, name in pairs:
        tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
        found = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.ClassDef)}
        found |= {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        assert name in found, (file, name)


@pytest.mark.parametrize("part", [*re.findall(r"`\.([\w.]+)`", tc.__doc__ or ""), "scene"])
def test_every_part_has_a_page_on_how_it_works(part):
    part = part.replace(".", "/")
    place = next(path for path in (ROOT / "tcontact" / part, ROOT / part) if path.is_dir())
    page = ast.get_docstring(ast.parse((place / "__init__.py").read_text(encoding="utf-8"))) or ""
    assert len(page) > 300, f"{part}: say how it works"


def test_the_rooms_stand_in_their_order():
    """CONTRIBUTING names the rooms of the house, and the page of the kernels theirs, from top to bottom."""
    table = TEXT.partition("## The house")[2].partition("What happens")[0]
    rows = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    named = re.findall(r"`(?:tcontact/)?([\w/.]+)`", " ".join(rows))
    names = [name.removesuffix("/").removesuffix(".py") for name in named]
    assert names == [name or "__init__" for name in house.ROOMS]
    page = ast.get_docstring(ast.parse((ROOT / "kernels" / "__init__.py").read_text(encoding="utf-8"))) or ""
    assert re.findall(r"^    (\w+) ", page, flags=re.M) == list(house.KERNEL_ROOMS)


def test_the_changelog_knows_the_version():
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"## {tc.__version__}" in text
    assert "## Unreleased" in text
