"""tcontact: dynamic contact and impact of deformable solids, on CPU and GPU.

How it works. Data flows one way, and nothing flows back:

    Mesh, Material, Body, obstacles -> Scene      plain data that checks itself (mesh*, materials, scene, obstacles)
    plan(scene)                                   decides what exists: terms, masses, contact lists (plan, removal)
    Run                                           state, compiled kernels and the loop (state, terms, schemes, loop)
    Result, result.vtkhdf, summary.json           what comes out (result, history, recorder, vtkhdf, report)
    pictures, plots, exports, notebooks           drawn from that alone (render, plots, export, notebook)

A body is a mesh whose nodes carry mass and whose cells carry stress. Every step the cells turn displacements into
forces (terms.internal_force), the scheme turns forces into motion, and the contact nodes, which carry no mass, are
placed by a small projected static solve (terms.static_solve): the contact force is the elastic force that is left on
them. A ledger keeps energy, impulse and momenta of every step, and guards stop a run that is wrong.

Pages on the parts: `pydoc tcontact.terms`, `.schemes`, `.obstacles`, `.friction_layer`, `.kernels`, `.cases`,
`.render`, `.study`, `.bench`, `.commands`.
"""

from importlib import import_module
from pathlib import Path
from typing import Any

from .version import __version__ as __version__

_root = Path(__file__).resolve().parent.parent
if (_root / "kernels").is_dir() and (_root / "cases").is_dir():
    __path__.append(str(_root))  # a bare checkout: tcontact.kernels and tcontact.cases lie beside the package

from . import notebook as _notebook  # noqa: E402
from .checkpoint import Checkpoint  # noqa: E402
from .contact_models import ImpulseContact, MasslessContact, PenaltyContact  # noqa: E402
from .dissipation import BulkViscosity, MassDamping  # noqa: E402
from .errors import InputError, OutputError  # noqa: E402
from .friction_models import Coulomb, FrictionLayer, RegularizedCoulomb  # noqa: E402
from .materials import LinearElastic, Material, MooneyRivlin, NeoHookean, Ogden, StVenantKirchhoff  # noqa: E402
from .mesh import Mesh  # noqa: E402
from .mesh_box import box_mesh  # noqa: E402
from .mesh_io import read_mesh  # noqa: E402
from .obstacles import Box, Cylinder, Plane, Sdf, Sphere  # noqa: E402
from .plan import plan  # noqa: E402
from .result import Result  # noqa: E402
from .resume import resume  # noqa: E402
from .scene import Body, OverlapWarning, Scene, Support  # noqa: E402
from .scene_files import load_scene, save_scene  # noqa: E402
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
from .simulate import simulate  # noqa: E402
from .warning_kinds import EnergyWarning, LayerWarning, LockingWarning, RotationWarning  # noqa: E402

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
    "EnergyWarning",
    "FrictionLayer",
    "Gonzalez",
    "HilberHughesTaylor",
    "ImpulseContact",
    "InputError",
    "LayerWarning",
    "LinearElastic",
    "LockingWarning",
    "MassDamping",
    "MasslessContact",
    "Material",
    "Mesh",
    "Midpoint",
    "MooneyRivlin",
    "NeoHookean",
    "Ogden",
    "OutputError",
    "OverlapWarning",
    "PaperImplicit",
    "PenaltyContact",
    "Plane",
    "RegularizedCoulomb",
    "Result",
    "RotationWarning",
    "Scene",
    "Sdf",
    "Sphere",
    "StVenantKirchhoff",
    "StressAveraging",
    "Support",
    "TransportAveraging",
    "Trapezoidal",
    "box_mesh",
    "friction_layer",
    "load_scene",
    "plan",
    "read_mesh",
    "resume",
    "save_scene",
    "simulate",
]

Result.notebook = _notebook


def __getattr__(name: str) -> Any:
    """Parts that are imported when first used."""
    if name == "friction_layer":
        return import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
