"""One body stepped implicitly: from level to level by Newton's method, the step halved where that fails."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....planning.applied_loads import constant_forces
from ....planning.body_plan import BodyPlan
from ....scene.body import Body
from ....scene.scene import Scene
from .cells import Cells
from .contact import StepContact
from .equations import Rows, StaticEquations, StepEquations
from .linear_solver import choose, make_solver
from .mass import ConsistentMass, NodalMass
from .newton import NotConverged, Settings, newton
from .rule import ImplicitRule
from .several_cells import SeveralCells, cells_of

DEEPEST = 10  # maximum number of halvings of a step
RECOVER = 4  # successful steps before the next is twice as long


@dataclass
class Level:
    """Displacement, velocity, acceleration, internal force [n, 3] and contact force [p, k, 3] of a level of time."""

    u: np.ndarray
    v: np.ndarray
    a: np.ndarray
    force: np.ndarray
    contact: np.ndarray


@dataclass
class Taken:
    """The result of a step.

    dt [s]; contact [p, k, 3] [N]: mean contact force of every obstacle; reaction [n, 3] [N]: reaction of supports;
    loads [p, 6]: force [N] and moment [N m] on every obstacle; iterations: of Newton's method; residual: at its end.
    """

    dt: float
    contact: np.ndarray
    reaction: np.ndarray
    loads: np.ndarray
    iterations: int
    residual: float

    @property
    def forces(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Forces of its impulse: contact, reaction, loads."""
        return self.contact, self.reaction, self.loads


def stiffness_ratio(body: Body) -> float:
    """Return the largest lambda/mu of the materials of a body."""
    return max(material.lame_lambda / material.lame_mu for material in body.materials)


class ImplicitBody:
    """The equations of a body under an implicit scheme, with their solvers and settings."""

    def __init__(self, scene: Scene, plan: BodyPlan, scheme: ImplicitRule) -> None:
        self.plan, self.scheme = plan, scheme
        count = len(plan.reference)
        self.cells = cells_of([(block.own, block.cells) for block in plan.blocks], plan.reference)
        self.mass = NodalMass(plan) if scheme.mass == "lumped" else ConsistentMass(plan, self.cells.sparsity)
        self.weight = self.mass.times(np.tile(plan.gravity, (count, 1)))
        self.applied = constant_forces(plan) if plan.body.loads else None
        self.load = self.weight if self.applied is None else self.weight + self.applied
        held = np.zeros((count, 3, 3))
        self.support_nodes = plan.boundary[plan.support_rows]
        held[self.support_nodes, plan.support_axes, plan.support_axes] = 1.0
        self.held = held
        self.contact = None if plan.contact is None else StepContact(scene, plan, held)
        self.rows = self._rows(self.cells, held, self.contact, None if self.contact is None else self.contact.nodes)
        self.equations = StepEquations(scheme, self.cells, self.mass, self.contact, self.rows, self.load)
        self.solver_kind = choose(3 * count, stiffness_ratio(plan.body), scheme.solver)
        self.solver = make_solver(self.solver_kind, self.cells.sparsity)
        self.settings = Settings(scheme.rtol, scheme.iterations, scheme.verbose)
        self.massless = self.contact is not None and self.contact.massless
        self.reproject = self.massless and scheme.reprojects
        self.statics = self._statics() if self.massless else None
        self.depth, self.good = 0, 0
        self.failed: Level | None = None  # where the part of a step began that did not converge
        # contact force, reaction and loads of the step before, of which v1 - v0 takes a share under some schemes
        self.before = self.at_rest(0.0).forces

    def _rows(
        self, cells: Cells | SeveralCells, held: np.ndarray, contact: StepContact | None, place: np.ndarray | None
    ) -> Rows:
        where = np.zeros(0, dtype=np.int64) if place is None else place
        areas = np.zeros(len(where))
        if self.plan.contact is not None:
            areas = self.plan.contact.areas
        stiff = self._modulus * np.sqrt(areas)
        return Rows(cells.sparsity, held, contact, where, stiff)

    @property
    def _modulus(self) -> float:
        """The largest lambda + 2 mu of its materials [Pa]."""
        return max(material.wave_modulus for material in self.plan.body.materials)

    def _statics(self) -> tuple[StaticEquations, object]:
        """Return the static problem of the massless components alone, and its solver."""
        plan = self.plan
        assert self.contact is not None
        assert plan.contact is not None
        assert plan.contact.basis is not None
        basis = plan.contact.basis
        held = np.eye(3) - np.einsum("kic,kjc->kij", basis, basis)
        contact = self.contact.moved_along(held)
        touching = [(block, np.isin(block.cells, contact.nodes).any(axis=1)) for block in plan.blocks]
        blocks = [(block.own, block.cells[inside]) for block, inside in touching]
        cells = cells_of(blocks, plan.reference, contact.nodes)
        rows = self._rows(cells, held, contact, np.arange(len(contact.nodes)))
        equations = StaticEquations(
            cells, contact, rows, self.load[contact.nodes],
            self._modulus, float(plan.contact.areas.mean()),
        )  # fmt: skip
        kind = choose(3 * len(contact.nodes), stiffness_ratio(plan.body), self.scheme.solver)
        return equations, make_solver(kind, cells.sparsity)

    def massive(self, v: np.ndarray) -> np.ndarray:
        """Return the velocity [n, 3] without its massless components."""
        contact = self.plan.contact
        if contact is None or contact.basis is None:
            return v
        result = v.copy()
        along = np.einsum("kic,ki->kc", contact.basis, v[contact.nodes])
        result[contact.nodes] -= np.einsum("kic,kc->ki", contact.basis, along)
        return result

    def equilibrium(self, u: np.ndarray) -> np.ndarray:
        """Return u [n, 3] with massless components in equilibrium, all others fixed. Raises `NotConverged`."""
        assert self.contact is not None
        assert self.statics is not None
        equations, solver = self.statics
        own, exact = equations.contact.exact, self.contact.exact
        equations.prepare(u)
        start = np.zeros((len(equations.contact.nodes), 3))
        if own is not None and exact is not None:  # from the set of the step, which then goes on from this one
            own.active = exact.active.copy()
        moved = equations.moved(newton(equations, start, solver, self.settings).d)  # type: ignore[arg-type]
        if own is not None and exact is not None:
            exact.active = own.active.copy()
        return moved

    def start(self, u: np.ndarray, v: np.ndarray) -> Level:
        """Return the level at the start; u, v: displacement and velocity [n, 3]. Raises `NotConverged`."""
        looks_back = self.scheme.blend != 1.0
        if self.massless and (self.reproject or self.scheme.balances_the_end or looks_back):
            u = self.equilibrium(u)
        level = self._level(u, self.massive(v), np.zeros_like(v))
        if looks_back:
            self._forces(level)
            right = self.load - level.force
            if self.contact is not None:
                right[self.contact.nodes] += level.contact.sum(axis=0)
            level.a = self.mass.solve(right)
            reaction = self.mass.times(level.a) - right
            if self.contact is not None and self.contact.exact is not None and len(self.contact.nodes):
                level.contact = self.contact.closed(reaction, level.u)
                reaction[self.contact.nodes] -= level.contact.sum(axis=0)
            reaction = np.einsum("nij,nj->ni", self.held, reaction)
            self.before = level.contact, reaction, self._loads(level.contact, level.u)
        return level

    def at_rest(self, dt: float) -> Taken:
        """Return a step of dt [s] without contact and reactions."""
        loads = np.zeros((len(self.no_contact), 6))
        return Taken(dt, self.no_contact, np.zeros((len(self.plan.reference), 3)), loads, 0, 0.0)

    def _loads(self, force: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return force and moment on every obstacle [p, 6] of contact forces [p, k, 3] at u [n, 3]."""
        return np.zeros((0, 6)) if self.contact is None else self.contact.loads(force, u)

    @property
    def no_contact(self) -> np.ndarray:
        """Return zero contact forces [p, k, 3]."""
        return np.zeros((0, 0, 3) if self.contact is None else self.contact.shape)

    def _level(self, u: np.ndarray, v: np.ndarray, a: np.ndarray) -> Level:
        return Level(u, v, a, np.zeros_like(u), self.no_contact)

    def _forces(self, level: Level) -> None:
        self.cells.evaluate("end", level.u, np.zeros_like(level.u))
        level.force = self.cells.force(1.0)
        if self.contact is not None and self.contact.penalty is not None and len(self.contact.nodes):
            level.contact = self.contact.at(level.u)[0]

    def take(self, level: Level, dt: float) -> tuple[Level, Taken]:
        """Take one step of dt [s]. Raises `NotConverged`."""
        scheme, equations = self.scheme, self.equations
        factor, known = scheme.inertia(dt, level.v, level.a)
        if scheme.past != 0.0:
            self._forces(level)
        equations.prepare(level.u, factor, known, scheme.past * level.force, scheme.past * level.contact)
        start = np.zeros_like(level.u)
        start[self.support_nodes, self.plan.support_axes] = self.plan.speeds * dt
        solution = newton(equations, start, self.solver, self.settings)
        equations.evaluate(solution.d)
        v, a = scheme.motion(dt, solution.d, level.v, level.a)
        u = level.u + solution.d
        reaction = np.einsum("nij,nj->ni", self.held, equations.unbalanced)
        force = equations.contact_force.copy()
        loads = self._loads(force, 0.5 * (level.u + u))
        if self.reproject:
            u = self.equilibrium(u)
        taken = Taken(dt, force, reaction, loads, solution.iterations, solution.residual)
        return self._level(u, self.massive(v), self.massive(a)), taken

    def _blended(self, taken: Taken) -> Taken:
        """Return the step with the forces of its impulse, a mean with those of the step before."""
        share = self.scheme.blend
        if share == 1.0:
            return taken
        pairs = zip(taken.forces, self.before, strict=True)
        contact, reaction, loads = (share * now + (1.0 - share) * before for now, before in pairs)
        self.before = taken.forces
        return replace(taken, contact=contact, reaction=reaction, loads=loads)

    def advance(self, level: Level, dt: float) -> tuple[Level, Taken]:
        """Advance by dt [s], halved until Newton's method converges. Raises `NotConverged` if it never does."""
        done, parts = 0, []
        full = 1 << DEEPEST
        while done < full:
            while done % (full >> self.depth):
                self.depth += 1
            share = full >> self.depth
            try:
                level, taken = self.take(level, dt * share / full)
            except NotConverged as error:
                if self.depth == DEEPEST:
                    self.failed = level
                    later = f"{dt * done / full:.6g} s later, " if done else ""
                    raise NotConverged(f"{later}also with a step of {dt * share / full:.3g} s: {error}") from error
                self.depth, self.good = self.depth + 1, 0
                continue
            parts.append(self._blended(taken))
            done += share
            self.good += 1
            if self.good >= RECOVER and self.depth:
                self.depth, self.good = self.depth - 1, 0
        weights = [part.dt / dt for part in parts]
        forces = zip(*(part.forces for part in parts), strict=True)
        contact, reaction, loads = (np.tensordot(weights, np.array(force), 1) for force in forces)
        iterations = sum(part.iterations for part in parts)
        return level, Taken(dt, contact, reaction, loads, iterations, max(part.residual for part in parts))
