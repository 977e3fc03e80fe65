"""tcontact: dynamic contact and impact of deformable solids, on CPU and GPU."""

from importlib import import_module
from pathlib import Path
from typing import Any

__version__ = "0.1.0"

_root = Path(__file__).resolve().parent.parent
if (_root / "kernels").is_dir() and (_root / "cases").is_dir():
    __path__.append(str(_root))  # a bare checkout: tcontact.kernels and tcontact.cases lie beside the package

from .contact_models import ImpulseContact, MasslessContact, PenaltyContact  # noqa: E402
from .dissipation import BulkViscosity, MassDamping  # noqa: E402
from .errors import InputError  # noqa: E402
from .friction_models import Coulomb, FrictionLayer, RegularizedCoulomb  # noqa: E402
from .materials import LinearElastic, Material, NeoHookean, StVenantKirchhoff  # noqa: E402
from .mesh import Mesh  # noqa: E402
from .mesh_box import box_mesh  # noqa: E402
from .mesh_io import read_mesh  # noqa: E402
from .obstacles import Box, Cylinder, Plane, Sdf, Sphere  # noqa: E402
from .plan import plan  # noqa: E402
from .result import Result  # noqa: E402
from .scene import Body, OverlapWarning, Scene, Support  # noqa: E402
from .scene_files import load_scene, save_scene  # noqa: E402
from .schemes import CentralDifference  # noqa: E402
from .simulate import simulate  # noqa: E402

__all__ = [
    "Body",
    "Box",
    "BulkViscosity",
    "CentralDifference",
    "Coulomb",
    "Cylinder",
    "FrictionLayer",
    "ImpulseContact",
    "InputError",
    "LinearElastic",
    "MassDamping",
    "MasslessContact",
    "Material",
    "Mesh",
    "NeoHookean",
    "OverlapWarning",
    "PenaltyContact",
    "Plane",
    "RegularizedCoulomb",
    "Result",
    "Scene",
    "Sdf",
    "Sphere",
    "StVenantKirchhoff",
    "Support",
    "box_mesh",
    "friction_layer",
    "load_scene",
    "plan",
    "read_mesh",
    "save_scene",
    "simulate",
]


def __getattr__(name: str) -> Any:
    """Parts that are imported when first used."""
    if name == "friction_layer":
        return import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
