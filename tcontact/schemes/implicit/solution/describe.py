"""Describe a plan under an implicit scheme: equations, unknowns, sizes and the choice of the linear solver."""

from __future__ import annotations

import numpy as np

from ....planning.body_plan import BodyPlan
from ....planning.planning import Plan
from .linear_solver import DIRECT, STIFF, choose
from .rule import ImplicitRule


def describe(plan: Plan, scheme: ImplicitRule) -> str:
    """Describe the terms, then size, kernels, sparsity and solver of every body."""
    reduced = any(block.formulation == "reduced" for body in plan.bodies for block in body.body.blocks)
    lost = {"angular momentum"} if reduced and scheme.hourglass_level != 0.5 else set()
    loss = scheme.contact_loss(plan.scene)
    lost |= {"energy"} if loss else set()
    conserved = ", ".join(one for one in scheme.conserves if one not in lost)
    lines = ["terms: " + ", ".join(plan.terms), f"scheme: {scheme.name}, order {scheme.order}, conserves {conserved}"]
    if loss and "energy" in scheme.conserves:
        lines.append(f"  energy: kept but for contact; {loss}, the less the smaller the step is")
    for body in plan.bodies:
        lines += _body(body, scheme)
    return "\n".join(lines)


def _body(body: BodyPlan, scheme: ImplicitRule) -> list[str]:
    mesh, own = body.body.mesh, body.body.blocks
    unknowns = 3 * mesh.node_count
    left, right = np.broadcast_arrays(mesh.cells[:, :, None], mesh.cells[:, None, :])
    blocks = len(np.unique(left.astype(np.int64) * mesh.node_count + right))
    ratio = max(block.material.lame_lambda / block.material.lame_mu for block in own)
    kind = choose(unknowns, ratio, scheme.solver)
    if scheme.solver != "auto":
        why = "as asked for"
    elif kind == "krylov":
        why = f"more than {DIRECT} unknowns, lambda/mu = {ratio:.3g} below {STIFF:g}"
    elif unknowns <= DIRECT:
        why = f"no more than {DIRECT} unknowns"
    else:
        why = f"lambda/mu = {ratio:.3g} is {STIFF:g} or more"
    solver = {"direct": "sparse LU factors (SuperLU)", "krylov": "BiCGStab, inverse diagonal blocks"}[kind]
    size = blocks * 9 * 8 * (3 if kind == "krylov" else 4)
    for block in own:
        points = len(block.cells) * (1 if block.formulation == "reduced" else len(block.facts.weights))
        size += points * 8 * (9 + 81 + 2 + 3 * block.facts.corners)
    laws = list(dict.fromkeys(block.material.law for block in own))
    lines = [f"{body.label}: {mesh.cell_count} {body.element} cells, {mesh.node_count} nodes, {' + '.join(laws)}"]
    rules = [scheme.stress] if scheme.stress == "end" else [scheme.stress, "end"]
    lines.append(
        "  kernels: " + ", ".join([f"points({law}, {rule})" for law in laws for rule in rules] + ["forces", "tangents"])
    )
    lines.append(f"  tangent: {unknowns} unknowns, {blocks} blocks of 3x3, not symmetric; about {size / 1e6:.3g} MB")
    lines.append(f"  linear solver: {solver}: {why}")
    contact = body.contact
    if contact is not None:
        massless = contact.basis is not None
        lines.append(f"  contact: {len(contact.nodes)} nodes{' without mass' if massless else ''}, mass {scheme.mass}")
    return lines
