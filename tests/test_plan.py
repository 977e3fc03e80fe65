"""Only what a scene needs exists: terms, memory, modules."""

import json

import pytest
from scenes import block, material, python, simulate, thrown

import tcontact as tc

FLOOR = tc.Plane(point=(0.0, 0.0, -1.0))
FULL_MEMORY = {"state", "internal-force", "boundary-nodes"}


def scene_with(obstacles=(), contact=None, gravity=None, supports=(), touching=True, friction=None, loads=()):
    touches = "zmin" if touching else None
    body = tc.Body(block(cells=2), material("linear"), contact=touches, supports=supports, loads=loads)
    return tc.Scene(
        bodies=[body], obstacles=obstacles, duration=1e-5, gravity=gravity, contact=contact, friction=friction
    )


PULL, HELD = (0.0, 0.0, -9.81), (tc.Support("xmin", "x"),)
SCENES = {
    "bare": (scene_with(), ["internal-force", "ledger"], {"state", "internal-force"}),
    "model but no wall": (
        scene_with(contact=tc.MasslessContact()),
        ["internal-force", "ledger"],
        {"state", "internal-force"},
    ),
    "wall but no contact set": (
        scene_with([FLOOR], tc.MasslessContact(), touching=False),
        ["internal-force", "ledger"],
        {"state", "internal-force"},
    ),
    "gravity": (scene_with(gravity=PULL), ["internal-force", "gravity", "ledger"], {"state", "internal-force"}),
    "zero gravity": (scene_with(gravity=(0, 0, 0.0)), ["internal-force", "ledger"], {"state", "internal-force"}),
    "supports": (scene_with(supports=HELD), ["internal-force", "supports", "ledger"], FULL_MEMORY | {"supports"}),
    "loads": (
        scene_with(loads=[tc.Load("zmax", pressure=1e3), tc.Load("xmin", force=lambda t: (t, 0.0, 0.0))]),
        ["internal-force", "loads", "ledger"],
        FULL_MEMORY,
    ),
    "gravity in time": (
        scene_with(gravity=lambda t: (0.0, 0.0, -t)),
        ["internal-force", "gravity", "ledger"],
        FULL_MEMORY,
    ),
    "massless": (
        scene_with([FLOOR], tc.MasslessContact()),
        ["internal-force", "massless-contact", "ledger"],
        FULL_MEMORY | {"massless-contact"},
    ),
    "penalty": (
        scene_with([FLOOR], tc.PenaltyContact(1e8)),
        ["internal-force", "penalty-contact", "ledger"],
        FULL_MEMORY | {"penalty-contact"},
    ),
    "impulse": (
        scene_with([FLOOR], tc.ImpulseContact()),
        ["internal-force", "impulse-contact", "ledger"],
        FULL_MEMORY | {"impulse-contact"},
    ),
    "coulomb": (
        scene_with([FLOOR], tc.MasslessContact(removal="full"), friction=tc.Coulomb(0.3)),
        ["internal-force", "massless-contact", "coulomb-friction", "ledger"],
        FULL_MEMORY | {"massless-contact", "coulomb-friction"},
    ),
    "regularized": (
        scene_with([FLOOR], tc.PenaltyContact(1e8), friction=tc.RegularizedCoulomb(0.3, 0.1)),
        ["internal-force", "penalty-contact", "regularized-friction", "ledger"],
        FULL_MEMORY | {"penalty-contact", "regularized-friction"},
    ),
    "friction layer": (
        scene_with([FLOOR], tc.MasslessContact(), friction=tc.FrictionLayer()),
        ["internal-force", "massless-contact", "friction-layer", "cell-viscosity", "ledger"],
        FULL_MEMORY | {"massless-contact", "friction-layer", "cell-viscosity"},
    ),
    "friction without a wall": (
        scene_with(contact=tc.MasslessContact(), friction=tc.FrictionLayer()),
        ["internal-force", "ledger"],
        {"state", "internal-force"},
    ),
    "moving wall": (
        scene_with([tc.Sphere((0, 0, -3.0), 1.0, velocity=(0, 0, 1.0))], tc.MasslessContact()),
        ["internal-force", "massless-contact", "ledger"],
        FULL_MEMORY | {"massless-contact"},
    ),
    "all": (
        scene_with([FLOOR], tc.MasslessContact(), PULL, HELD),
        ["internal-force", "gravity", "supports", "massless-contact", "ledger"],
        FULL_MEMORY | {"supports", "massless-contact"},
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_terms_and_memory_are_those_of_the_scene(name):
    scene, terms, memory = SCENES[name]
    planned = tc.plan(scene)
    assert list(planned.terms) == terms
    assert ", ".join(terms) in planned.describe()
    result = simulate(scene)
    assert list(result.terms) == terms
    assert set(result.memory) == memory
    assert all(size > 0 for size in result.memory.values())


def test_memory_counts_what_the_terms_own():
    """State: two float64 vectors a node; a support term: an int32 and a float64 a component."""
    result = simulate(SCENES["supports"][0])
    assert result.memory["state"] == 27 * 3 * 8 * 2
    assert result.memory["supports"] == 9 * (4 + 8)
    more = tc.Scene(bodies=[tc.Body(block(cells=4), material("linear"))], duration=1e-5, contact=None)
    assert simulate(more).memory["state"] == 125 * 3 * 8 * 2


def test_contact_lists_hold_the_contact_set_alone():
    scene = thrown(cells=4, contact=tc.MasslessContact(removal="full"))
    body = tc.plan(scene).bodies[0]
    mesh = scene.bodies[0].mesh
    assert sorted(body.node_order[body.contact.nodes]) == sorted(mesh.nodes_of("zmin"))
    assert sorted(body.cell_order[body.contact.graph.cells]) == list(range(16))  # the lowest layer
    assert body.contact.areas.sum() == pytest.approx(0.2 * 0.22, rel=1e-12)
    assert len(body.boundary) == 50  # contact nodes and the layer that received their mass


CODE = """
import json, sys
import scenes, test_plan, tcontact as tc
from tcontact.device import runtime
name = sys.argv[1]
before = {m for m in sys.modules if m.startswith("tcontact.")}
scene, _, _ = test_plan.SCENES[name]
tc.plan(scene)
tables = (".lanes", ".columns", ".node_places", ".pair_places", ".rigid_places", ".volume_places", ".load_places",
          ".layer_places", ".sweep_places")
kernels = [m for m in sys.modules if m.startswith("tcontact.kernels.") and not m.endswith(tables)]
assert not kernels and "taichi" not in sys.modules, "planning needs no kernels"
result = tc.simulate(scene, threads=2)
made = {}
for module in [m for m in sys.modules if m.startswith("tcontact.kernels.")]:
    for key, value in vars(sys.modules[module]).items():
        if hasattr(value, "cache_info") and value.__module__ == module:
            made[module.removeprefix("tcontact.kernels.") + "." + key] = value.cache_info().currsize
modules = sorted(m.removeprefix("tcontact.") for m in sys.modules if m.startswith("tcontact."))
print(json.dumps({"ok": result.ok, "modules": modules, "made": made}))
"""
UNUSED = {  # parts of names of kernel modules, rooms among them, and of factories
    "bare": ("contact", "massless", "static", "surface", "boundary", "images", "raster", "rigid_body", "nodes.loads"),
    "massless": (
        "contact_load",
        "kick_friction",
        "layer1d",
        "images",
        "raster",
        "rigid_body",
        "free_obstacles",
        "rigid_rate",
        "nodes.loads",
    ),
    "penalty": ("massless", "static", "surface", "kick_friction", "layer1d", "images", "raster"),
    "coulomb": ("contact_load", "kick_friction", "layer1d", "images", "raster"),
    "friction layer": ("contact_load", "images", "raster"),
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name not in ("bare", "massless"))) for name in UNUSED]
)
def test_kernels_of_other_terms_are_never_imported_or_made(name):
    """In a fresh process: which kernel modules are in memory, and which kernel variants their factories made."""
    done = python(CODE, name)
    assert done.returncode == 0, done.stderr[-2000:]
    report = json.loads(done.stdout.splitlines()[-1])
    assert report["ok"]
    kernels = {module.removeprefix("kernels.") for module in report["modules"] if module.startswith("kernels.")}
    assert "step.internal_force" in kernels
    assert ("static.solve" in kernels) == (name not in ("bare", "penalty"))
    assert not [module for module in kernels if any(part in module for part in UNUSED[name])]
    assert not {"show.render", "show.plots", "commands.cli"} & set(report["modules"])
    made = {factory: count for factory, count in report["made"].items() if count}
    assert {"step.internal_force.make_step", "step.serial_step.make_serial_step"} <= made.keys()
    assert ("static.solve.make_resolve" in made) == (name not in ("bare", "penalty"))
    assert all(made[factory] == 1 for factory in made), made  # one cell kind, one law, one block: one variant each
    assert not [factory for factory in made if any(part in factory for part in UNUSED[name])]


@pytest.mark.parametrize("name", sorted(SCENES))
def test_the_plan_names_its_terms_and_foresees_the_memory(name):
    """describe() lists the terms; what it says a term will take is what the run takes, to a fifth."""
    from tcontact.planning.describe import memory

    scene = SCENES[name][0]
    planned = tc.plan(scene)
    text = planned.describe()
    assert all(term in text for term in planned.terms)
    taken = simulate(scene).memory
    foreseen = {}
    for domain in planned.domains:
        for term, size in memory(planned, domain).items():
            foreseen[term] = foreseen.get(term, 0) + size
    assert set(foreseen) == set(taken)
    for term, size in taken.items():
        assert foreseen[term] == pytest.approx(size, rel=0.2, abs=512), term


def test_describing_a_plan_is_light():
    """It needs no Taichi: `describe` says what a run would take before anything is started."""
    code = "import sys, tcontact as tc; from tcontact.cases import cube_impact; "
    code += "tc.plan(cube_impact.scene(cells=2)).describe(); print('taichi' in sys.modules)"
    done = python(code)
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.split()[-1] == "False"
