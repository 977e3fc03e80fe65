"""The part that a rank has of a plan: little memory, with the mesh that its arrays say."""

import pickle
from dataclasses import fields, is_dataclass

import numpy as np
import pytest

import tcontact as tc
from tcontact.mesh.mesh import Mesh
from tcontact.planning.partition.domain_part import cut_domain, domain_part
from tcontact.planning.partition.message import packed, unpacked
from tcontact.planning.partition.outline import outlined, told
from tcontact.planning.planning import plan
from tcontact.scene.body import Body

pytest.importorskip("pymetis", reason="METIS cuts the meshes: pip install pymetis")

RANKS = 4


def scene_of(kind="hex8", count=24, sets=None):
    """A cube above a plane; sets: of cells, with one material."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (count,) * 3, kind).translated((0.0, 0.0, 1e-3))
    mesh = mesh.with_sets(cell_sets=sets) if sets else mesh
    material = tc.NeoHookean(young=1e7, poisson=0.3, density=1e3)
    given = dict.fromkeys(sets, material) if sets else material
    body = tc.Body(mesh, given, (0.0, 0.0, -1.0), contact="zmin", formulation="full")
    return tc.Scene([body], [tc.Plane()], duration=1e-3, contact=tc.MasslessContact())


def sent(scene, rank):
    """The part of a rank, as the rank gets it, and as the first one has made it."""
    planned = plan(scene)
    domain = planned.domains[0]
    made = domain_part(domain, cut_domain(domain, scene, RANKS, 1), rank)
    outline = outlined(scene, told(planned))
    return unpacked(pickle.loads(pickle.dumps(packed(made))), outline.domains[0], scene), made


def arrays_of(thing, found):
    """Collect the memory of all arrays that a part holds, by its place; a view counts as what it stands in."""
    if isinstance(thing, np.ndarray):
        while isinstance(thing.base, np.ndarray):
            thing = thing.base
        found[id(thing)] = thing
    elif isinstance(thing, (list, tuple)):
        for one in thing:
            arrays_of(one, found)
    elif isinstance(thing, (Mesh, Body)):
        for one in vars(thing).values():
            arrays_of(one, found)
    elif is_dataclass(thing):
        for field in fields(thing):
            if field.name != "whole":
                arrays_of(getattr(thing, field.name), found)
    return found


@pytest.mark.parametrize("rank", [1, 3])
def test_a_rank_holds_few_bytes_for_each_of_its_cells(rank):
    """40 of a cell, 68 of each of 1.2 nodes, 250 of nodes on the cut: its cells in 64 bits once more would be 64."""
    scene = scene_of()
    found, _ = sent(scene, rank)
    known = arrays_of(scene.bodies[0], {})  # what all ranks have of the scene
    own = [array.nbytes for place, array in arrays_of(found.bodies, {}).items() if place not in known]
    assert sum(own) < 180 * len(found.bodies[0].part.cells)


@pytest.mark.parametrize(("kind", "several"), [("hex8", 1), ("tet4", 6), ("wedge6", 2)])
def test_the_first_rank_makes_parts_of_a_large_box_without_its_cells(kind, several, monkeypatch):
    """Those that a hexahedron is cut into stay together; parts are as equal, and the contact as whole, as ever."""
    monkeypatch.setattr("tcontact.planning.partition.domain_part.FINE", 0)
    scene = scene_of(kind, count=12)
    domain = plan(scene).domains[0]
    cut = cut_domain(domain, scene, RANKS, 1)
    mesh = scene.bodies[0].mesh
    parts = [domain_part(domain, cut, rank) for rank in range(RANKS)]
    assert not {"nodes", "cells", "blocks"} & set(vars(mesh))
    assert (cut.reshape(-1, several) == cut.reshape(-1, several)[:, :1]).all()
    sizes = np.bincount(cut)
    assert sizes[1:].max() - sizes[1:].min() <= 0.02 * sizes[1:].mean() + several
    assert sum(len(part.bodies[0].part.cells) for part in parts) == mesh.cell_count
    touching = np.isin(mesh.cells, scene.bodies[0].contact_nodes).any(axis=1)
    assert not cut[touching].any()


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_the_mesh_of_a_part_is_that_of_its_cells(kind):
    scene = scene_of(
        kind, 6, {"low": np.arange(40), "rest": np.arange(40, 6**3 * {"hex8": 1, "tet4": 6, "wedge6": 2}[kind])}
    )
    whole = scene.bodies[0].mesh
    for rank in range(1, RANKS):
        for own in sent(scene, rank):
            part, mesh = own.bodies[0].part, own.bodies[0].plan.body.mesh
            assert (mesh.node_count, mesh.cell_count) == (len(part.nodes), len(part.cells))
            assert not {"nodes", "cells"} & set(vars(mesh))
            assert np.array_equal(mesh.nodes, whole.nodes[part.nodes])
            assert np.array_equal(part.nodes[mesh.cells], whole.cells[part.cells])
            assert mesh.cell_counts == ((kind, len(part.cells)),)
            for name, numbers in mesh.cell_sets.items():
                assert np.array_equal(part.cells[numbers], np.intersect1d(whole.cell_sets[name], part.cells))
            again = pickle.loads(pickle.dumps(mesh))
            assert np.array_equal(again.cells, mesh.cells)
            mesh.release()
            assert not {"nodes", "cells", "blocks"} & set(vars(mesh))
