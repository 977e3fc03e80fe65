"""The script docs/phone_drop.py, on a small mesh of the same nature: a shell of tetrahedra around a core."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
from mesh_files import write_gmsh41

import tcontact as tc
from tcontact.results import checks as ck

SCRIPT = Path(__file__).resolve().parents[1] / "docs" / "phone_drop.py"
SIZE, WALL = np.array([150.0, 75.0, 12.0]), 1.5  # [mm]


def write_phone(path):
    """A box open at the top, with walls one cell thick, around a core that is lower than its edge."""
    counts = np.array([7, 5, 5])
    box = tc.box_mesh(counts, counts)
    nodes = np.empty((box.node_count, 3))
    for axis, count in enumerate(counts):
        lines = np.r_[0.0, np.linspace(WALL, SIZE[axis] - WALL, count - 1), SIZE[axis]]
        nodes[:, axis] = lines[box.nodes[:, axis].astype(int)]
    cells = tc.box_mesh(counts, counts, "tet4").cells
    grid = nodes[cells].mean(axis=1)
    inside = ((grid > WALL) & (grid < SIZE - [WALL, WALL, 0.0])).all(axis=1)
    above = inside & (grid[:, 2] > SIZE[2] - WALL)
    used, number = np.unique(cells[~above], return_inverse=True)
    rows, core = number.reshape(-1, 4), inside[~above]
    skin = tc.Mesh(nodes[used], rows, "tet4").boundary_faces()
    x = nodes[used][skin]
    screen = skin[(np.ptp(x[:, :, 2], axis=1) == 0) & np.isclose(x[:, :, 2].min(axis=1), SIZE[2] - WALL)]
    blocks = [("triangle", 1, [3], screen), ("tet4", 1, [1], rows[~core]), ("tet4", 2, [2], rows[core])]
    names = {(3, 1): "case", (3, 2): "core", (2, 3): "screen"}
    write_gmsh41(path, nodes[used], list(range(1, len(used) + 1)), blocks, names, True)


def test_the_script_drops_a_phone_on_its_corner(tmp_path, monkeypatch, capsys):
    assert len(SCRIPT.read_text(encoding="utf-8").splitlines()) <= 30
    write_phone(tmp_path / "phone.msh")
    monkeypatch.setattr(sys, "argv", [str(SCRIPT), str(tmp_path / "phone.msh")])
    found = runpy.run_path(str(SCRIPT))
    result, mesh = found["result"], found["mesh"]
    assert "finished" in capsys.readouterr().out
    assert np.array_equal(np.sort(np.concatenate([*mesh.cell_sets.values()])), np.arange(mesh.cell_count))
    assert len(mesh.faces_of("screen")) > 20
    middle, lowest = mesh.nodes.mean(axis=0), mesh.nodes[mesh.nodes[:, 2].argmin()]
    assert np.linalg.norm(lowest - middle) == pytest.approx(np.linalg.norm(mesh.nodes - middle, axis=1).max(), rel=5e-2)
    volume = ck.volume(mesh)
    assert volume < np.prod(SIZE) * 1e-9
    assert result.history["contact_force"][:, 2].max() > 10.0
    assert ck.momentum_balance(result, 1e-9).passed
    assert ck.energy(result, 5e-3).passed
