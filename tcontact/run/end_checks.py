"""Check the history of a finished run for large energy errors, hourglassing, long plastic steps and inaccurate layers.

Each warning gives the error and what reduces it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.warning_kinds import EnergyWarning, HourglassWarning, LayerWarning, PlasticStepWarning
from ..scene.contact_models import ImpulseContact, MasslessContact, PenaltyContact
from ..scene.friction_models import FrictionLayer
from ..scene.obstacles import Sdf
from ..scene.scene import Scene
from ..schemes import Scheme

LARGE = 0.05  # largest energy error that needs no warning, over the largest kinetic and elastic energy of the run
HOURGLASSING = 0.1  # largest share of hourglass modes in the energy of deformation that needs no warning
FAR = 5.0  # largest error of the friction layers that needs no warning, over their tolerance
UNBALANCED = 0.02  # largest static residual of pairs of bodies that needs no warning
MISSED = 10.0  # the same over the tolerance that the user set
ROUNDED = 1e-10  # static residual that rounding may leave of bodies far from where they started
LONGEST_FLOW = 0.1  # plastic strain of a step up to which the return to the yield surface is accurate


def end_warnings(
    scene: Scene,
    scheme: Scheme,
    history: dict[str, np.ndarray],
    dt: float,
    rounding: float,
    worst: tuple[float, float],
    entered: str = "",
) -> list[tuple[str, type[Warning]]]:
    """Return the warnings about a finished run: text and class.

    history: as in `Result`; dt [s]: first step; worst: as for `energy_warning`, up to `rounding` it is no error;
    entered: bodies that met with faces that contact does not hold, and the remedy, or "" (`Looks.entered`).
    """
    found = [
        (energy_warning(scene, scheme, dt, rounding, worst, entered), EnergyWarning),
        (hourglass_warning(history, rounding), HourglassWarning),
        (flow_warning(history, dt), PlasticStepWarning),
        (layer_warning(scene, history), LayerWarning),
        (residual_warning(scene, history), RuntimeWarning),
    ]
    return [(text, kind) for text, kind in found if text is not None]


def residual_warning(scene: Scene, history: dict[str, np.ndarray]) -> str | None:
    """Return a warning about the largest static residual of a run with pairs of bodies; None where it is small.

    Their normals and weights change with the motion, so that a step takes a limited number of linear problems. Small is
    up to `UNBALANCED`, and where the user set a tolerance also up to `MISSED` times that: the residual of a row holds
    what the step's last linear problem left, which is measured after it, and is some times the tolerance in runs whose
    every step met it (a stack of five blocks at rest: 2.4 times 1e-6).
    """
    residual = history["static_residual"]
    if not scene.body_pairs or not len(residual):
        return None
    row = int(np.argmax(residual))
    left = f"the static solve between bodies left a residual of {residual[row]:.2g} at t = {history['time'][row]:.6g} s"
    wanted = scene.contact.tolerance if isinstance(scene.contact, MasslessContact) else None
    if wanted is not None and residual[row] > max(MISSED * wanted, ROUNDED):
        return (
            f"{left}, and more than MasslessContact.tolerance = {wanted:g} in {int((residual > wanted).sum())} of"
            f" {len(residual)} rows: between bodies a step takes a limited number of linear problems, so that contact"
            " forces may be that far from balance; to lower it use a smaller cfl or dt together with a smaller"
            " tolerance, or set the tolerance that the run needs"
        )
    if not residual[row] > UNBALANCED:
        return None
    return (
        f"{left}: contact forces were that far from balance; use a smaller cfl or dt,"
        " or cells of more even shape at the contact"
    )


def hourglass_warning(history: dict[str, np.ndarray], rounding: float) -> str | None:
    """Return a warning about the energy in hourglass modes; None up to a tenth of the largest energy of deformation.

    That is the elastic energy, and of metals what flow and softened hourglass modes dissipated. rounding: share of the
    largest kinetic and elastic energy up to which an energy is none.
    """
    if "hourglass" not in history or not len(history["time"]):
        return None
    lost = history.get("hourglass_work", 0.0)
    modes = history["hourglass"] + lost
    whole = float((history["elastic"] + history.get("plastic_work", 0.0) + lost).max())
    row = int(np.argmax(modes))
    floor = rounding * float((history["kinetic"] + history["elastic"]).max())
    if not modes[row] > max(HOURGLASSING * whole, floor):
        return None
    return (
        f"the hourglass energy of one-point hexahedra reached {modes[row] / whole:.2g} of the largest energy of"
        f" deformation (at t = {history['time'][row]:.6g} s): their hourglass stiffness is not that of the material, so"
        " that bending, and what else varies from cell to cell, comes out wrong; use finer cells, where a body bends"
        " several layers about as long as high, or formulation='full' or 'mean-dilatation'"
    )


def flow_warning(history: dict[str, np.ndarray], dt: float) -> str | None:
    """Return a warning about a step [s] in which a point flowed by more than 0.1; None for smaller ones, or no metal.

    The largest plastic strain of all points rises by no more than some point flows; rows apart count by their mean.
    """
    if "plastic_strain_max" not in history or len(history["time"]) < 2:
        return None
    steps = np.diff(history["time"])
    flow = np.diff(history["plastic_strain_max"]) * np.minimum(1.0, dt / np.maximum(steps, 1e-300))
    row = int(np.argmax(flow))
    if not flow[row] > LONGEST_FLOW:
        return None
    when = f"at t = {history['time'][row + 1]:.6g} s"
    return (
        f"the plastic strain of a point grew by {flow[row]:.2g} in a step {when}; the flow of a step is accurate up to"
        f" {LONGEST_FLOW:g}: take smaller steps (cfl or dt), or a mesh whose cells do not collapse there"
    )


def energy_warning(
    scene: Scene,
    scheme: Scheme,
    dt: float,
    rounding: float,
    worst: tuple[float, float],
    entered: str = "",
) -> str | None:
    """Return a warning about the energy error of the run and what reduces it; None up to 5 %, or up to `rounding`.

    As in the history, the error is the largest change of the energy over the largest kinetic and elastic energy. worst:
    that of all steps, kept in the history or not, with the sign of the change, and its time [s]; entered: as for
    `end_warnings`, which is the cause then.
    """
    change, when = worst
    if not abs(change) > max(LARGE, rounding):
        return None
    what = "above" if change > 0.0 else "below"
    text = f"the energy error reached {abs(change):.2g} at t = {when:.6g} s, where the energy was {what}"
    return f"{text} that of the start; {entered or '; '.join(_remedies(scene, scheme, dt, change))}"


def _remedies(scene: Scene, scheme: Any, dt: float, change: float) -> list[str]:
    if scheme.implicit:
        return _implicit(scene, scheme, dt, change)
    if scene.touching and isinstance(scene.contact, ImpulseContact) and change < 0.0:
        remedy = "ImpulseContact loses energy in every impact by design, the less the finer the mesh"
        return [f"{remedy}: use MasslessContact, which conserves it"]
    found = []
    if scene.touching and isinstance(scene.contact, PenaltyContact):
        found.append("a penalty on nodes with mass changes the energy near its stable step: use MasslessContact")
    grids = [number for number, one in enumerate(scene.obstacles) if isinstance(one, Sdf)]
    if scene.touching and grids:
        names = ", ".join(scene.obstacle_label(number) for number in grids)
        found.append(
            f"the grid of Sdf {names} interpolates distance and gradient apart, which changes the energy at any step:"
            " give it more cells, or use Plane, Sphere, Cylinder or Box where the shape is one"
        )
    if scheme.dt is None:
        found.append(f"use a smaller cfl, for example {0.5 * scheme.step_size(1.0):.2g}")
    else:
        found.append(f"use a smaller dt, for example {0.5 * dt:.2g} s")
    if scene.body_pairs:
        found[-1] += ", or name the body with the sharper edge as slave (Pair(slave=)), or refine the contact faces"
        if any(len(body.contact_faces) < len(body.outer_faces) for body in scene.bodies if body.contact is not None):
            found[-1] += ", or give contact='all' to bodies that turn, whose other faces may meet too"
    if scene.viscosity is None:
        found.append("for shocks give the scene viscosity=tc.BulkViscosity(), whose work is in the ledger")
    return found


def _implicit(scene: Scene, scheme: Any, dt: float, change: float) -> list[str]:
    smaller = f"use a smaller dt, for example {0.5 * dt:.2g} s"
    if "energy" in scheme.conserves:
        loss = scheme.contact_loss(scene) if change < 0.0 else None
        if loss is not None:
            return [f"{loss}: {smaller}, or MasslessContact(penalty=) and reproject=False, which keep it"]
        return [f"{scheme.name} conserves energy only as far as its equations are solved: {smaller}, or a smaller rtol"]
    if scheme.dissipates:
        return [f"{scheme.name} dissipates by design, the less the smaller dt is: {smaller}, or discrete-gradient"]
    return [f"{scheme.name} does not conserve energy: use discrete-gradient, or {smaller}"]


def layer_warning(scene: Scene, history: dict[str, np.ndarray]) -> str | None:
    """Return a warning about the error of the layers and what reduces it; None up to five times their tolerance."""
    model, error = scene.friction, history.get("layer_error", np.zeros(0))
    if not isinstance(model, FrictionLayer) or not len(error) or not np.nanmax(error) > FAR * model.tolerance:
        return None
    row = int(np.nanargmax(error))
    if history["layer_substeps"].max() >= model.substeps:
        remedy = f"give the layers more than substeps={model.substeps}, or use a smaller cfl or dt"
    else:
        remedy = "use a smaller cfl or dt"
        if isinstance(scene.contact, MasslessContact) and scene.contact.removal != "normal":
            remedy += "; removal='normal' solves the layers together with the motion"
    return (
        f"layer_error reached {error[row]:.2g} at t = {history['time'][row]:.6g} s,"
        f" {error[row] / model.tolerance:.2g} times FrictionLayer.tolerance = {model.tolerance:g}; {remedy}"
    )
