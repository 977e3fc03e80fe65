"""tcontact: dynamic contact and impact of deformable solids, computed by Taichi kernels.

How it works. Data flows one way, and nothing flows back:

    Mesh, Material, Body, obstacles -> Scene      plain data that checks itself (mesh, scene)
    plan(scene)                                   decides what exists: terms, masses, contact lists (planning)
    Domain, CellBlock, Island                     bodies in one numbering, their cells and contact nodes (planning)
    Run                                           state, kernels, the loop (nodes, cells, contact, schemes, run)
    Result, result.vtkhdf, summary.json           what comes out (results)
    pictures, curves, notebooks                   drawn from that alone (show)

Every name in brackets is a room of the house, a package below this one; a room imports only what stands below it:
`commands`, `lab` and `cases` above, then `show`, `run`, `schemes`, `contact`, `cells`, `nodes`, `results`, `planning`,
`scene`, `friction_layer`, `mesh`, `device`, the `kernels` and `base` below.

A body is a mesh whose nodes carry mass and whose cells carry stress. Every step the cells turn displacements into
forces (cells.internal_force), the scheme turns forces into motion, the obstacles fill the constraint rows of the
contact nodes (contact.constraint_rows), and these nodes, which carry no mass, are placed by a small projected static
solve (contact.static_solve): the contact force is the elastic force that is left on them. A ledger keeps energy,
impulse and momenta of every step, and guards stop a run that is wrong.

Pages on the parts: `pydoc tcontact.scene`, `.mesh`, `.planning`, `.nodes`, `.cells`, `.contact`, `.schemes`, `.run`,
`.results`, `.device`, `.friction_layer`, `.kernels`, `.cases`, `.commands`, `.show.render`, `.scene.obstacles`,
`.lab.study`, `.lab.bench`.
"""

from importlib import import_module
from pathlib import Path
from typing import Any

from .base import moved
from .base.version import __version__ as __version__

_root = Path(__file__).resolve().parent.parent
if (_root / "kernels").is_dir() and (_root / "cases").is_dir():
    __path__.append(str(_root))  # a bare checkout: tcontact.kernels and tcontact.cases lie beside the package

from .base.errors import InputError, OutputError  # noqa: E402
from .base.errors import hint as _hint  # noqa: E402
from .base.warning_kinds import (  # noqa: E402
    EnergyWarning,
    HourglassWarning,
    LayerWarning,
    LockingWarning,
    MeshWarning,
    PlasticStepWarning,
    RemovalWarning,
    RotationWarning,
    SlaveWarning,
)
from .device.last_words import take_part as _take_part  # noqa: E402
from .device.ranks import is_first_rank  # noqa: E402
from .friction_layer.steinberg_guinan import SteinbergGuinan  # noqa: E402
from .mesh.box import box_mesh  # noqa: E402
from .mesh.files import meshes_of_others as _meshes_of_others  # noqa: E402
from .mesh.files.reading import read_mesh  # noqa: E402
from .mesh.mesh import Mesh  # noqa: E402
from .mesh.round import ball_mesh, cylinder_mesh, ring_mesh  # noqa: E402
from .planning.planning import plan  # noqa: E402
from .results.outcome import Outcome as _Outcome  # noqa: E402
from .results.result import Result  # noqa: E402
from .results.stored import StoredResult, open_result  # noqa: E402
from .run.checkpoint import Checkpoint  # noqa: E402
from .run.resumption import resume  # noqa: E402
from .run.scene_files import load_scene, save_scene  # noqa: E402
from .run.simulation import simulate  # noqa: E402
from .scene.body import Body  # noqa: E402
from .scene.contact_models import ImpulseContact, MasslessContact, PenaltyContact  # noqa: E402
from .scene.dissipation import BulkViscosity, MassDamping  # noqa: E402
from .scene.friction_models import Coulomb, FrictionLayer, FrictionTable, NoFriction, RegularizedCoulomb  # noqa: E402
from .scene.loads import Load  # noqa: E402
from .scene.materials import LinearElastic, Material, MooneyRivlin, NeoHookean, Ogden, StVenantKirchhoff  # noqa: E402
from .scene.metal_presets import metal  # noqa: E402
from .scene.metals import ElastoPlastic, JohnsonCook, LinearHardening, MieGrueneisen  # noqa: E402
from .scene.obstacles import Box, Cylinder, Plane, Sdf, Sphere  # noqa: E402
from .scene.own_laws import register_law  # noqa: E402
from .scene.pairs import Pair  # noqa: E402
from .scene.probes import Probe  # noqa: E402
from .scene.rigid import RigidPart  # noqa: E402
from .scene.scene import OverlapWarning, Scene  # noqa: E402
from .scene.springs import PointMass, Spring  # noqa: E402
from .scene.strain import Strain  # noqa: E402
from .scene.supports import Support  # noqa: E402
from .schemes import (  # noqa: E402
    CentralDifference,
    DiscreteGradient,
    Dissipative,
    Gonzalez,
    HilberHughesTaylor,
    Midpoint,
    PaperImplicit,
    StressAveraging,
    TransportAveraging,
    Trapezoidal,
)

__all__ = [
    "Body",
    "Box",
    "BulkViscosity",
    "CentralDifference",
    "Checkpoint",
    "Coulomb",
    "Cylinder",
    "DiscreteGradient",
    "Dissipative",
    "ElastoPlastic",
    "EnergyWarning",
    "FrictionLayer",
    "FrictionTable",
    "Gonzalez",
    "HilberHughesTaylor",
    "HourglassWarning",
    "ImpulseContact",
    "InputError",
    "JohnsonCook",
    "LayerWarning",
    "LinearElastic",
    "LinearHardening",
    "Load",
    "LockingWarning",
    "MassDamping",
    "MasslessContact",
    "Material",
    "Mesh",
    "MeshWarning",
    "Midpoint",
    "MieGrueneisen",
    "MooneyRivlin",
    "NeoHookean",
    "NoFriction",
    "Ogden",
    "OutputError",
    "OverlapWarning",
    "Pair",
    "PaperImplicit",
    "PenaltyContact",
    "Plane",
    "PlasticStepWarning",
    "PointMass",
    "Probe",
    "RegularizedCoulomb",
    "RemovalWarning",
    "Result",
    "RigidPart",
    "RotationWarning",
    "Scene",
    "Sdf",
    "SlaveWarning",
    "Sphere",
    "Spring",
    "StVenantKirchhoff",
    "SteinbergGuinan",
    "StoredResult",
    "Strain",
    "StressAveraging",
    "Support",
    "TransportAveraging",
    "Trapezoidal",
    "ball_mesh",
    "box_mesh",
    "cylinder_mesh",
    "friction_layer",
    "is_first_rank",
    "load_scene",
    "metal",
    "open_result",
    "plan",
    "read_mesh",
    "register_law",
    "resume",
    "ring_mesh",
    "save_scene",
    "simulate",
]

moved.install()
_take_part()


class _Later:
    """A module that is imported when something of it is first used: pictures cost a run that draws none nothing."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, name: str) -> Any:
        return getattr(import_module(f"{__name__}.{self._name}"), name)


Result.notebook = _Later("show.notebook")
Mesh.readers = _meshes_of_others
Mesh.views = Scene.views = _Outcome.views = _Later("show.views")
StoredResult.made_again = staticmethod(
    lambda summary, folder: import_module(f"{__name__}.commands.origins").made_again(summary, folder)
)


def __getattr__(name: str) -> Any:
    """Return a part that is imported when it is first used, or a module by its old name."""
    if name == "friction_layer" or moved.destination(name):
        return import_module(f"{__name__}.{name}")
    guess = _hint(name, __all__).rstrip()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}" + (f"; {guess}" if guess else ""))
