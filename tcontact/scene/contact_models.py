"""Contact models, for rigid obstacles and between bodies."""

from __future__ import annotations

from dataclasses import dataclass

from ..base import validate


@dataclass(frozen=True)
class MasslessContact:
    """Contact nodes without mass, resolved by a projected static solve every step (METHOD 1 and 2, paper 4.2-4.3).

    removal: the mass that the contact nodes lose: "normal" (only along the obstacle normal), "full" (all of it) or
    "auto" (normal if all obstacles are planes of one direction that the contact faces face, and the body does not start
    with a spin that turns it by more than 0.05 rad in the duration; else full). Metals lose all of it in slow impacts
    alone, rho v^2/Y <= 0.1 (`InputError` above); "normal" and "auto" go along the normals of planes of one direction,
    else along those of their own contact faces.
    penalty: None for the exact constraint, else the stiffness per area [N/m^3] of the obstacle surface.
    depth: layers of nodes that receive the mass (1 = the paper). sweeps: minimum number of sweeps of a step whose
    residual is not 0.
    tolerance: bound on `static_residual` (relative); None means 1e-4, with the sweeps going on to 1e-6 if they can;
    below 1e-6 rows of pairs of bodies are built anew after less slip, too, which keeps the angular momentum. It is no
    bound where bodies are pairs: their rows change with the motion, so that a step solves at most 3 linear problems (8
    with a metal) and goes on with what residual they leave. With None and friction that was up to 4e-3 (a block that
    lands on two others that touch), with 1e-6 still 2e-4, with 1e-7 at cfl .2 7e-6: a smaller tolerance lowers it, and
    below about 1e-6 a smaller cfl does too. A run that ends above 0.02, or above ten times a tolerance that was set
    (a step that met it may end at some times as much), says so.
    solver: of the static solve: "gauss-seidel" sweeps, "projected-gradient" (MPRGP: conjugate gradients with bounds,
    for one obstacle, or several beside pairs of bodies, without friction in the massless components and without
    penalty; `sweeps` then counts products with the stiffness) or "auto" (the second where the first needs many sweeps;
    `Plan.describe` names it with the reason). cell_viscosity: beta >= 0 of a Kelvin-Voigt stress eta C D in the contact
    cells, with the elastic stiffness C, the strain rate D and eta = beta h/c (h: shortest height of a hex, those of
    other cells times 1.41; c: wave speed). Without it, sliding nodes with tangential mass flutter at the scale of the
    mesh. None means `friction_models.CELL_VISCOSITY` where friction meets normal removal; 0 turns it off. Elsewhere
    there is none, and a number is refused. History: `viscous_work` [J], dissipated so far.
    sweeps, tolerance and solver are those of explicit steps: implicit ones solve contact within Newton's method.
    """

    removal: str = "auto"
    penalty: float | None = None
    depth: int = 1
    sweeps: int = 10
    tolerance: float | None = None
    cell_viscosity: float | None = None
    solver: str = "auto"

    def __post_init__(self) -> None:
        validate.choice("removal", self.removal, ("auto", "normal", "full"))
        validate.choice("solver", self.solver, ("auto", "gauss-seidel", "projected-gradient"))
        if self.penalty is not None:
            validate.keep(self, "penalty", low=0.0)
        validate.whole("depth", self.depth, 1, 1000)
        validate.whole("sweeps", self.sweeps, 1, 10**6)
        if self.tolerance is not None:
            validate.keep(self, "tolerance", low=0.0)
        if self.cell_viscosity is not None:
            validate.keep(self, "MasslessContact.cell_viscosity", low=0.0, high=1e3, strict=False)


@dataclass(frozen=True)
class PenaltyContact:
    """A penalty on nodes with their ordinary mass: the usual baseline.

    stiffness: contact pressure over the overlap [N/m^3] > 0. Between bodies it acts on the nodes of the slave, each on
    its closest master face. It cuts the stable step (`Result.dt_limit` includes it). Raises `InputError`.
    """

    stiffness: float

    def __post_init__(self) -> None:
        validate.keep(self, "stiffness", low=0.0)


@dataclass(frozen=True)
class ImpulseContact:
    """Impulses that stop closed nodes, which have their ordinary mass, with restitution 0 (Moreau-Jean; METHOD 2).

    Forces are smooth, and an impact loses energy of the order of the size of the cells.
    """


ContactModel = MasslessContact | PenaltyContact | ImpulseContact
