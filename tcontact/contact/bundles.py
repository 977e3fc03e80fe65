"""Bundles of the terms of a domain (kernels/language/bundles.py), for kernels that step it or solve for its contact.

A term that the domain does not have gives an empty bundle, of which the kernel has no arguments. The arrays of the body
are the first arguments; they are asked for at every launch, since a pass may be at another displacement.
"""

from __future__ import annotations

from typing import Any

from ..device import arrays
from ..nodes.boundary_nodes import BoundaryNodes, Supports
from ..nodes.rigid_bodies import RigidBodies
from .static_solve import StaticSolve
from .term import ContactTerm


def boundary_bundle(boundary: BoundaryNodes | None, sums: arrays.Array, **more: arrays.Array) -> Any:
    """Return the bundle of the boundary nodes; sums: of the step (kernels/columns.py); more: further fields."""
    from ..kernels.language.bundles import Boundary

    return Boundary(**({} if boundary is None else boundary.arguments()), **more, sums=sums)


def support_bundle(supports: Supports | None, sums: arrays.Array) -> Any:
    """Return the bundle of the supports, empty without any."""
    from ..kernels.language import bundles

    return bundles.Supports() if supports is None else bundles.Supports(**supports.arguments(), sums=sums)


def rigid_bundle(rigid: RigidBodies | None, sums: arrays.Array) -> Any:
    """Return the bundle of the rigid bodies, empty without any."""
    from ..kernels.language.bundles import Rigid

    return Rigid() if rigid is None else Rigid(**rigid.arguments(), sums=sums)


def contact_bundles(contact: ContactTerm | None, sums: arrays.Array, **more: Any) -> dict[str, Any]:
    """Return the bundles of the obstacles, the constraint rows and the contact nodes; more: further fields of the last.

    Without contact the first two are empty, and the last one has `sums` and the further fields only.
    """
    from ..kernels.language.bundles import Contact, Obstacles, Rows

    if contact is None:
        return {"obstacles": Obstacles(), "rows": Rows(), "contact": Contact(sums=sums, **more)}
    return {
        "obstacles": Obstacles(**contact.obstacle_arguments()),
        "rows": Rows(**contact.row_arguments()),
        "contact": Contact(**contact.arguments(), sums=sums, **more),
    }


def solve_bundles(solve: StaticSolve | None) -> dict[str, Any]:
    """Return the bundles of the static solve: stiffness between pairs of nodes, linear problem; empty without one."""
    from ..kernels.language.solve_bundles import Pairs, System

    if solve is None:
        return {"pairs": Pairs(), "system": System()}
    return {"pairs": Pairs(**solve.pairs), "system": System(**solve.system)}


def within_limit(bundles: dict[str, Any], solve: StaticSolve | None) -> dict[str, Any]:
    """Return the bundles with the lists of "pairs" in one array, if they hold more arrays than a kernel takes."""
    from ..kernels.language.joint_lists import joined
    from ..kernels.language.signatures import MAXIMUM_ARGUMENTS, arguments
    from ..kernels.language.solve_bundles import PAIR_LISTS, JointPairs

    if solve is None or len(arguments(bundles)) <= MAXIMUM_ARGUMENTS:
        return bundles
    lists = arrays.put(joined([arrays.get(solve.pairs[name]) for name in PAIR_LISTS]))
    return bundles | {"pairs": JointPairs(lists, solve.pairs["shape_gradients"], solve.pairs["values"])}


def behind_body(bundles: dict[str, Any]) -> tuple[arrays.Array, ...]:
    """Return the arguments of a kernel behind those of "body", the first of its bundles."""
    from ..kernels.language.signatures import arguments

    return arguments(bundles)[len(arguments({"body": bundles["body"]})) :]


def place_behind_body(bundles: dict[str, Any], name: str) -> int:
    """Return the place among `behind_body` of the first array of a bundle."""
    names = list(bundles)
    return len(behind_body({before: bundles[before] for before in names[: names.index(name)]}))
