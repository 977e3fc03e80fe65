"""Import modules by their old names, with a warning, for one version.

`tcontact.checks`, `tcontact.errors`, `tcontact.render` and `tcontact.obstacles` remain valid and do not warn.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

PACKAGE = __name__.partition(".")[0]
KEPT = {"errors": "base.errors", "checks": "results.checks", "obstacles": "scene.obstacles", "render": "show.render"}
# package: the modules that moved into it, as old=new where the name has changed too
ROOMS = {
    "commands": "cli commands.resume=resuming",
    "friction_layer": "friction_layer.solve=solution",
    "lab": "bench study numbers",
    "lab.study": "study.friction_layer=layer_study",
    "show": "plots notebook",
    "run": (
        "simulate=simulation resume=resumption loop guards history recorder snapshot progress interrupts "
        "folder_lock end_checks worst_cell checkpoint scene_files"
    ),
    "run.watches": "looks far_watch normal_watch path_watch body_meeting",
    "schemes.explicit": "schemes.central_difference state stable_step damped_step terms.serial_step",
    "schemes.implicit": (
        "schemes.discrete_gradient schemes.dissipative schemes.gonzalez schemes.hilber_hughes_taylor "
        "schemes.midpoint schemes.paper_implicit schemes.transport_averaging schemes.trapezoidal "
        "implicit=solution"
    ),
    "contact": (
        "terms.contact=term terms.massless_contact terms.static_solve terms.obstacles terms.friction "
        "terms.friction_layer=layered_friction"
    ),
    "cells": "terms.internal_force terms.cell_viscosity stress",
    "nodes": "terms.boundary_nodes terms.images",
    "results": "result smoothness report export=exporting study.exact frame_fields",
    "results.files": "vtkhdf vtkhdf_reader vtu_file xdmf_file",
    "planning": (
        "plan=planning describe packing contact_graph sweep_order lumped_mass removal redistribution "
        "rotation locking measured"
    ),
    "scene": "contact_models friction_models dissipation materials periodic reach",
    "mesh": "mesh_box=box mesh_geometry=geometry mesh_checks=checks mesh_rotation=rotation triangle_distance",
    "mesh.files": (
        "mesh_io=reading mesh_file=content mesh_meshio=meshio_files mesh_guard=meshio_guard mesh_abaqus=abaqus"
    ),
    "device": "runtime arrays launch tracing atomic_file",
    "base": "validate warning_kinds",
    "kernels.step": "kernels.internal_force kernels.raw_rows kernels.serial_step",
    "kernels.static": (
        "kernels.massless_contact kernels.massless_node kernels.reduced_tangent kernels.static_control=control "
        "kernels.static_friction=sliding kernels.static_solve=solve kernels.surface_tangent kernels.sweeps"
    ),
    "kernels.contact": (
        "kernels.cell_viscosity kernels.contact_load kernels.friction kernels.kick_friction kernels.local_contact "
        "kernels.obstacle_queries kernels.obstacle_shapes kernels.obstacles"
    ),
    "kernels.cells": (
        "kernels.cell_phase kernels.implicit_cells kernels.implicit_laws=implicit_rules kernels.implicit_points "
        "kernels.plain_force kernels.von_mises"
    ),
    "kernels.nodes": "kernels.boundary_nodes kernels.damping kernels.images kernels.node_phase",
    "kernels.layer": (
        "kernels.layer1d kernels.layer1d_phases kernels.layer1d_residual kernels.layer1d_secant kernels.layer1d_solve"
    ),
    "kernels.elements": (
        "kernels.bulk_viscosity kernels.mean_dilatation=hex8_mean_dilatation kernels.reduced_hex=hex8_reduced"
    ),
    "kernels.materials": "kernels.law_tangents=law",
    "kernels.language": (
        "kernels.arguments kernels.bundles kernels.compile_options kernels.implicit_stress=implicit_geometry "
        "kernels.tensor3 kernels.transcendental kernels.vectors"
    ),
    "kernels.pictures": "kernels.raster",
}
MOVED = {
    old: f"{room}.{new or old.rpartition('.')[2]}"
    for room, names in ROOMS.items()
    for old, _, new in (name.partition("=") for name in names.split())
} | {"terms": "contact", "kernels.laws": "kernels.materials"}
# former modules whose names are functions now, of the package or of a part of it
FUNCTIONS = ("plan", "resume", "simulate", "friction_layer.solve")


def destination(name: str) -> str | None:
    """Return the present name of a module by its old one, both below `tcontact`; None if it has not moved."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        head = ".".join(parts[:count])
        new = MOVED.get(head) or KEPT.get(head)
        if new:
            return ".".join([new, *parts[count:]])
    return None


def warn(name: str, new: str) -> None:
    """Warn of an old name, unless it remains valid."""
    if name.split(".")[0] not in KEPT:
        text = f"tcontact.{name} is tcontact.{new} now; the old name goes with the next version"
        warnings.warn(text, DeprecationWarning, stacklevel=3)


class OldNames(MetaPathFinder, Loader):
    """Finds a module by its old name; the module object is that of the new name."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        """Return a spec for a module that has moved, None for all others."""
        package, _, rest = name.partition(".")
        return ModuleSpec(name, self) if package == PACKAGE and destination(rest) else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Import the module by its present name."""
        rest = spec.name.partition(".")[2]
        new = destination(rest)
        assert new is not None
        warn(rest, new)
        module = import_module(f"{PACKAGE}.{new}")
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Do not execute the module again; restore its own spec."""
        if module.__spec__ is not None:
            module.__spec__ = module.__spec__.loader_state


class OldModule(ModuleType):
    """Stand-in for a module whose name is a function now, which an import must not replace."""

    def __getattr__(self, name: str) -> Any:
        """Return a name of the module from its present place."""
        if name.startswith("__"):
            raise AttributeError(name)
        old = self.__name__.partition(".")[2]
        warn(old, MOVED[old])
        return getattr(import_module(f"{PACKAGE}.{MOVED[old]}"), name)


def install() -> None:
    """Make the old names known to `import`."""
    sys.meta_path.insert(0, OldNames())
    for name in FUNCTIONS:
        sys.modules[f"{PACKAGE}.{name}"] = OldModule(f"{PACKAGE}.{name}")
