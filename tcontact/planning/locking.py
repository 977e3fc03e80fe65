"""Warn of volumetric locking: cells that resist volume change at every point come out too stiff near poisson 1/2.

Measured is the deflection of a cantilever with 2 cells across, against the same mesh at poisson 0.3. Linear tetrahedra
keep 82 % of it at poisson 0.4, 62 % at 0.45 and 25 % at 0.49, with formulation="node-averaged" 97, 94 and 87 %; prisms
87, 71 and 33 % where their triangles stand across it, 92, 83 and 62 % where they lie along it; hexahedra with full
integration 94, 86 and 65 %; with formulation="mean-dilatation" 99 %.
"""

from __future__ import annotations

from ..mesh.elements import FORMULATIONS
from ..scene.body import Body
from ..scene.cell_blocks import AVERAGED, ROUNDING, BodyBlock


def locking(body: Body, label: str) -> str | None:
    """Return a warning if the cells of a body lock, else None; the Poisson's ratio is that at small strains."""
    alone = len(body.mesh.cell_counts) == 1
    texts = [text for block in body.blocks if (text := _locking(block, label, alone)) is not None]
    return "; ".join(texts) if texts else None


def _locking(block: BodyBlock, label: str, alone: bool) -> str | None:
    poisson, material = block.material.poisson, block.material
    if material.plastic and block.formulation == "full":
        label = label if block.region is None else f"{block.region!r} of {label}"
        remedy = "use hexahedra with formulation='mean-dilatation' or 'reduced'"
        if AVERAGED in block.facts.formulations and alone and material.barotropic:
            remedy = f"leave the formulation out, which makes it {AVERAGED!r} (on one process)"
        elif AVERAGED in block.facts.formulations and alone:
            remedy += f", or a pressure without heat, such as 'bulk', for which {AVERAGED!r} is the default"
        return (
            f"plastic-locking: {label} is a metal, and {block.facts.plural} with full integration lock in plastic flow"
            f" (a copper bar at 227 m/s spreads to a foot radius of 5.0 to 5.3 instead of 7.2 mm); {remedy}"
        )
    if not poisson > FORMULATIONS[block.element].locks + ROUNDING:
        return None
    label = label if block.region is None else f"{block.region!r} of {label}"
    element, remedy = block.facts, "give formulation='mean-dilatation'"
    cells = f"{element.plural} with full integration" if len(element.weights) > 1 else f"linear {element.plural}"
    if AVERAGED in element.formulations and alone:
        remedy = f"leave the formulation out, which makes it {AVERAGED!r} (on one process)"
    elif "mean-dilatation" not in element.formulations:
        remedy = f"mesh the body with hex8 and {remedy}"
    if not material.volumetric:
        remedy += f" with NeoHookean, as {type(material).__name__} does not have it"
    return f"{label} has poisson {poisson:.5g}: {cells} lock there and come out too stiff; {remedy}"
