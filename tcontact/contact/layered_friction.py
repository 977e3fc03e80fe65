"""Friction layers under the contact nodes of a body, one each, between the contact load and the kick (METHOD 5).

|t| = min(stick, tau of the layer, mu P). On components with mass the layer is solved together with the kick that its
traction slows down: its heat is b t (v - dt t/(2M)). In the massless components of full removal, and while one layer
step spans several mechanical ones, the shear stress of the last layer step limits the friction, and the friction work
then heats the layer: what it cannot take in a step waits for the next one. With normal removal at obstacles of several
directions nodes have both, components without mass and friction of the kick: its work waits with that of the step.

Bodies that step together share the number of layer steps: the body that needs the shortest ones sets it for all.

On a GPU these numbers stand on the device (device_layers.py), where kernels/layer/device_layers.py does what is done
here: what is changed in one of them has to be changed in the other.
"""

from __future__ import annotations

import numpy as np

from ..cells.internal_force import InternalForce
from ..device import arrays
from ..friction_layer import LayerState
from ..kernels.layer_places import COOL, EASY, FIRST, MAXIMUM_SPAN, ROUNDING, SMALLEST_WORK, STEADY, WARM
from ..planning.domain import Domain
from ..scene.friction_laws import law_data, laws_in_use
from ..scene.friction_models import FrictionLayer, coefficient_of
from ..scene.layer_metals import all_kinds
from ..scene.scene import Scene
from .friction import Friction
from .heat_exchange import HeatExchange
from .node_layers import NodeLayers
from .pairs.pair_contact import PairContact
from .sliding_partners import SlidingPartners


def make_friction(scene: Scene, domain: Domain, static_friction: bool) -> Friction:
    """Make the friction of a domain."""
    assert scene.friction is not None
    assert domain.contact is not None
    if isinstance(scene.friction, FrictionLayer):
        return LayeredFriction(scene, domain, static_friction)
    areas = domain.contact.areas
    laws = law_data(scene, domain.pairs, areas)
    return Friction(scene.friction, len(areas), static_friction, laws, domain.records_friction)


class LayeredFriction(Friction):
    """Friction limited by a layer under every contact node [k].

    areas: area weights [k] [m^2], of slaves of a pair the area that the other body covers; partners: what the nodes
    slide on, None if there is one kind of layer, one coefficient and no pair.
    """

    def __init__(self, scene: Scene, domain: Domain, static_friction: bool) -> None:
        model = scene.friction
        assert isinstance(model, FrictionLayer)
        assert domain.contact is not None
        areas, starts = domain.contact.areas, domain.contact_start
        laws = law_data(scene, domain.pairs, areas)
        super().__init__(model, len(areas), static_friction, laws, domain.records_friction)
        self.model, self.areas = model, areas.copy()
        self.coefficients = np.full(len(areas), model.coefficient)
        places = {number: slice(*starts[place : place + 2]) for place, number in enumerate(domain.numbers)}
        kinds = all_kinds(scene, domain.numbers)
        every = np.arange(len(areas))
        nodes = [np.concatenate([every[places[number]] for number in bodies]) for bodies in kinds.values()]
        self.layers = NodeLayers(model, list(kinds), nodes, len(areas))
        self.partners: SlidingPartners | None = None
        self.exchange: HeatExchange | None = None
        # layer steps per mechanical step; mechanical steps per layer step
        self.substeps, self.span = min(FIRST, model.substeps), 1
        self.error = 0.0
        self._waiting = np.zeros(len(areas))  # friction work that has not yet heated the layers [J/m^2]
        # time integrals since the last layer step [Pa s]
        self._friction_impulse = np.zeros(len(areas))
        self._pressure_impulse = np.zeros(len(areas))
        self._elapsed, self._count, self._kick = 0.0, 0, 0.0
        self._pressed = np.zeros(len(areas), dtype=bool)
        self._last, self._force = np.zeros(len(areas)), np.zeros(len(areas))  # pressure [Pa], friction [N] before
        counts = np.diff(starts)
        self._first, self._body = starts[:-1][counts > 0], np.repeat(np.arange((counts > 0).sum()), counts[counts > 0])
        # of the last layer step: friction power [W/m^2], change of the surface temperature [K]
        self._power, self._warming = np.zeros(len(areas)), np.zeros(len(areas))
        self._softness, self._melting_rise = self.layers.softness(), self.layers.melting_rise()
        self._largest_work = np.zeros(len(self._first))  # of a step [J/m^2], for every body that has contact nodes
        self._slid = np.zeros(len(areas), dtype=bool)
        self._kick_work = np.zeros(len(areas))  # work of the last kick that the layers took with it [J/m^2]
        self._taken_over = False  # layers of another run
        self._owed = np.zeros(len(areas))  # work waiting at the end of the run before this one [J/m^2]
        # heat to obstacles and plastic work that do not count on the present area [J/m^2]
        self._given_before, self._plastic_before = np.zeros(len(areas)), np.zeros(len(areas))
        # a layer solved with a kick ends half a step after the row: values at the row are interpolated with this share
        # from those before the kick: surface temperature [K], shear stress [Pa], plastic work and heat to the obstacles
        # [J/m^2]
        self._share = 1.0
        self._start = np.zeros((4, len(areas)))

    def find_partners(
        self, scene: Scene, domain: Domain, candidates: arrays.Array, pairs: PairContact | None, force: InternalForce
    ) -> None:
        """Take over what the rows may belong to, candidates of obstacles and rows of pairs, and the cells to heat."""
        if any(any(kind.open_ends) for kind in self.layers.kinds):
            self.exchange = HeatExchange(domain, force, self.layers, pairs)
        own = any(coefficient_of(law) != self.model.coefficient for law in laws_in_use(scene))
        if len(self.layers.kinds) > 1 or own or pairs is not None:
            self.partners = SlidingPartners(scene, domain, list(self.layers.kinds), self.rows, candidates, pairs)

    def _follow_partners(self) -> None:
        """Change to the layers, areas and coefficients of what the nodes slide on now; heat [J] stays what it is."""
        if self.partners is None:
            return
        self.partners.look()
        self.layers.used[:] = self.partners.used
        self.coefficients = self.partners.coefficients
        ratio = self.areas / self.partners.areas
        if (ratio == 1.0).all():
            return
        self.areas = self.partners.areas.copy()
        for values in (
            self._waiting,
            self._kick_work,
            self._power,
            self._friction_impulse,
            self._pressure_impulse,
            self._last,
        ):
            values *= ratio
        for total, before in (
            (self.layers.cell("WORK"), self._owed),
            (self.layers.to_obstacles(), self._given_before),
            (self.layers.cell("PLASTIC_WORK"), self._plastic_before),
        ):
            before[:] = total - ratio * (total - before)

    def step(self, before: float, after: float) -> None:
        """Advance the layers and set the limit of friction for the next kick or static solve.

        before, after [s]: the steps that end and start at the present level.
        """
        self._follow_partners()
        if self.exchange is None:
            self._step(before, after)
            return
        self.exchange.set_far_ends(self.rows.pressing() > 0.0)
        left = self.exchange.heat_out()
        self._step(before, after)
        self.exchange.give(self.areas, left)

    def _step(self, before: float, after: float) -> None:
        """Advance the layers of the present partners as in `step`."""
        pressure = self.rows.pressing() / self.areas
        pressed = pressure > 0.0
        if (pressed & ~self._pressed).any():
            self.span = 1
        self._pressed = pressed
        kick = 0.5 * (before + after)
        force = self.node(self.names.FORCE)
        if self.static_friction:  # the work of a step is that of the mean friction before and after it
            self._collect(before, 0.5 * (self._force + force), 0.5 * (self._last + pressure))
            self._friction_impulse += self.node(self.names.KICK_FORCE) / self.areas * self._kick
        elif self._kick > 0.0:  # the kick belongs to the level before
            self._collect(self._kick, force, self._last)
        else:
            self._waiting += self._pending()
        self._note_power()
        self._last, self._force = np.maximum(pressure, 0.0), force
        self._note_onset(before if self.static_friction else kick)
        due = self._count >= self.span or after == 0.0 or (not self.static_friction and self.span == 1)
        if self._count and due:
            self._spend()
        if self.static_friction or self.span > 1:
            limit = np.where(pressed, self._shear_of_pressed(pressure), 1e300)
            self._share = 1.0
            self._kick, self._kick_work = kick, 0.0 * pressure
        else:
            self._share = before / (before + after) if kick > 0.0 else 1.0
            start = self._shear_of_pressed(pressure)
            self._start[:3] = self.layers.surface_temperature(), start, self.layers.cell("PLASTIC_WORK")
            if not self.layers.plain:
                self._start[3] = self.layers.to_obstacles()
            limit = self._solve(pressure, kick) if kick > 0.0 else np.zeros(len(pressure))
            self._kick = 0.0
        data = arrays.get(self.data).copy()
        self.numbers(data)[:, self.names.LIMIT] = np.minimum(limit * self.areas, 1e300)
        arrays.set_values(self.data, data)

    def _note_onset(self, dt: float) -> None:
        """End long layer steps when nodes start to slide; dt [s]: of the last kick or step.

        Work below the rounding error of (friction force) x (slip speed that friction removes) x dt is not of sliding.
        """
        work = self._work()
        rounding = ROUNDING * self._force * self.node(self.names.SPEED) * dt / self.areas
        self._largest_work = np.maximum(self._largest_work, np.maximum.reduceat(work, self._first))
        slides = work > np.maximum(SMALLEST_WORK * self._largest_work[self._body], rounding)
        if (slides & ~self._slid).any():
            self.span = 1
            if not self._slid.any():
                self.substeps = max(self.substeps, min(FIRST, self.model.substeps))
        self._slid = slides

    def _warmth(self) -> np.ndarray:
        """Return the rise [k] [K] that changes of the surface temperature are compared with."""
        rise = self.layers.surface_temperature() - self.model.initial_temperature
        return np.maximum(rise, WARM * self._melting_rise)

    def _note_power(self) -> None:
        """End a long layer step when the friction power differs so much from that of the last one that it shows.

        A half space that takes the heat w at a constant rate in the time t becomes warmer by softness w/sqrt(t).
        """
        if self.span == 1 or self._elapsed == 0.0:
            return
        other = np.abs(self._waiting - self._power * self._elapsed)
        warming = self._softness / np.sqrt(self._elapsed) * other
        if (warming / self._warmth()).max() > self.model.tolerance:
            self.span = 1

    def shear(self) -> np.ndarray:
        """Return the shear stress of the layers [k] [Pa]; 0 where the contact is open."""
        return np.asarray(self.layers.cell("STRESS")) / np.sqrt(3.0)

    def _shear_of_pressed(self, pressure: np.ndarray) -> np.ndarray:
        """Return the shear stress [k] [Pa] of the layers; its start value where a contact has just closed."""
        shear = self.shear()
        fresh = (pressure > 0.0) & (shear == 0.0)
        return np.where(fresh, self.layers.limit_stress(pressure), shear) if fresh.any() else shear

    def _solve(self, pressure: np.ndarray, kick: float) -> np.ndarray:
        """Solve layers and kick together; return the mean shear stress [Pa] over the kick [s]."""
        speed, mobility, mean = (
            self.node(number) for number in (self.names.SPEED, self.names.MOBILITY, self.names.MEAN_SPEED)
        )
        # the work of the kick is that of the mean of the speeds before and after it
        usual = self.shear() * kick
        mean = np.maximum(mean + np.where(usual > 0.0, self._waiting / np.where(usual > 0.0, usual, 1.0), 0.0), 0.0)
        before, cold = self.layers.cell("WORK"), self.layers.surface_temperature()
        parts = self.substeps
        dt = kick / parts
        mobility = mobility * self.areas / parts  # slip speed lost per shear stress in a part of the kick [m/(s Pa)]
        dry = self.coefficients * np.maximum(pressure, 0.0)
        total = np.zeros(len(speed))
        for _ in range(parts):
            stick = np.where(mobility > 0.0, speed / np.where(mobility > 0.0, mobility, 1.0), 1e300)
            shear = self._advance(mean, pressure, np.minimum(dry, stick), 0.5 * mobility, dt)
            speed = np.maximum(speed - mobility * shear, 0.0)
            mean = np.maximum(mean - mobility * shear, 0.0)
            total += shear
        self._kick_work = self.layers.cell("WORK") - before
        self._power, self._warming = self._kick_work / kick, self.layers.surface_temperature() - cold
        self._judge(speed > 0.0)
        return np.asarray(total / parts)

    def _pending(self) -> np.ndarray:
        """Return the friction work of the last kick that the layers have not taken [k] [J/m^2]."""
        kicked = self.names.KICK_WORK if self.static_friction else self.names.WORK
        return np.asarray(self.node(kicked) / self.areas - self._kick_work)

    def _work(self) -> np.ndarray:
        """Return the friction work of the last step and of the kick before it [k] [J/m^2]."""
        work = self.node(self.names.WORK)
        if self.static_friction:
            work += self.node(self.names.KICK_WORK)
        return np.asarray(work / self.areas)

    def _collect(self, dt: float, force: np.ndarray, pressure: np.ndarray) -> None:
        """Collect friction work and impulses of the last kick or step of dt [s]; force [k] [N], pressure [Pa]."""
        self._waiting += self._work()
        self._friction_impulse += force / self.areas * dt
        self._pressure_impulse += pressure * dt
        self._elapsed += dt
        self._count += 1

    def _spend(self) -> None:
        """Advance the layers over the time since their last step with the work that waits."""
        elapsed, self._count = self._elapsed, 0
        if elapsed == 0.0:
            return
        friction, pressure = self._friction_impulse / elapsed, self._pressure_impulse / elapsed
        able = (friction > 0.0) & (pressure > 0.0)
        wanted = np.where(able, np.maximum(self._waiting, 0.0), 0.0)
        speed = np.where(able, wanted / np.where(able, friction * elapsed, 1.0), 0.0)
        before, cold = self.layers.cell("WORK"), self.layers.surface_temperature()
        for _ in range(self.substeps):
            self._advance(speed, pressure, friction, np.zeros(len(speed)), elapsed / self.substeps)
        taken = self.layers.cell("WORK") - before
        self._waiting -= taken
        self._power, self._warming = taken / elapsed, self.layers.surface_temperature() - cold
        self._judge(speed > 0.0)
        self._friction_impulse[:], self._pressure_impulse[:], self._elapsed = 0.0, 0.0, 0.0

    def _advance(
        self, speed: np.ndarray, pressure: np.ndarray, cap: np.ndarray, drag: np.ndarray, dt: float
    ) -> np.ndarray:
        """Advance the layers by one step and return the shear stress that they transmit [k] [Pa]."""
        self.layers.advance(speed, pressure, cap, drag, dt)
        return np.asarray(np.minimum(self.shear(), cap))

    def _judge(self, sliding: np.ndarray) -> None:
        """Estimate the error of the last layer step and choose the length of the next ones.

        Backward Euler errs by half the second difference in a step; friction that uses the stress of the last step errs
        by its change since then. While a layer step spans several mechanical ones, the surface temperature of their
        rows errs by up to its change, and heating is not known within the step.
        """
        stress = self.layers.cell("STRESS")
        known = sliding & (stress > 0.0)
        change, last = self.layers.cell("CHANGE"), self.layers.cell("BEFORE")
        scale = np.where(known, stress, np.inf)
        off, drift = (float((np.abs(part) / scale).max()) for part in (0.5 * (change - last), change))
        warming = float((np.abs(self._warming) / self._warmth()).max())
        lagging = self.static_friction or self.span > 1  # friction uses the stress of the step before
        self.error = max(off, drift * self.substeps if lagging else 0.0, warming if self.span > 1 else 0.0)
        share = (max(off, drift, warming) if self.span > 1 else off) / self.model.tolerance
        # heating later than the work was done makes a layer near melting too soft
        cool = not known.any() or self.layers.cell("CLOSE")[known].min() > COOL
        if share > 1.0 or not cool:
            if self.span > 1:
                self.span = 1
            elif share > 1.0:
                self.substeps = min(self.model.substeps, int(np.ceil(self.substeps * min(2.0, np.sqrt(share)))))
        elif share < EASY and self.substeps > 1:
            self.substeps = -(-self.substeps // 2)
        elif drift < EASY * self.model.tolerance and warming < STEADY * self.model.tolerance:
            self.span = min(2 * self.span, MAXIMUM_SPAN)

    def row(self, late: float) -> dict[str, float]:
        """Return the columns of the layers by name.

        late [J]: friction work of the last kick after the row, which the heat at the row does not hold.
        """
        layers, model = self.layers, self.model
        done = layers.cell("WORK") + self._waiting - self._owed + self._pending()
        plastic = model.plastic_heat * (self._at_row(2, layers.cell("PLASTIC_WORK")) - self._plastic_before)
        if layers.plain:
            heat = float((self.areas * (model.heat_share * done + plastic)).sum()) - model.heat_share * late
            given = (1.0 - model.heat_share) * (float((self.areas * done).sum()) - late)
        else:
            given = self._to_obstacles(late)
            heat = float((self.areas * (done + plastic)).sum()) - late - given
        found = {}
        if self.exchange is not None:
            late_heat = (1.0 - self._share) * self.exchange.last
            found["body_heat"] = float((self.exchange.given - late_heat).sum())
            heat -= found["body_heat"]
        temperature, stress = self.fields()
        lowest = float(stress[stress > 0.0].min()) if (stress > 0.0).any() else float("nan")
        return found | {
            "layer_heat": heat,
            "obstacle_heat": given,
            "layer_temperature_max": float(temperature.max()),
            "layer_shear_min": lowest,
            "layer_error": self.error,
            "layer_substeps": self.substeps / self.span,
        }

    def _to_obstacles(self, late: float) -> float:
        """Return the heat [J] that went into the obstacles up to the row; late: as in `row`.

        Work that the layers have not taken yet is divided as what they took.
        """
        given, work = self.layers.to_obstacles(), self.layers.cell("WORK")
        share = np.where(work > 0.0, given / np.where(work > 0.0, work, 1.0), 0.0).clip(0.0, 1.0) * self.areas
        found = (self.areas * (self._at_row(3, given) - self._given_before)).sum() + (share * self._waiting).sum()
        last = self._pending()
        found += (share * last).sum()
        if self._share == 1.0 and (self.areas * last).sum() > 0.0:  # the layers did not take the kick with it
            found -= late * (share * last).sum() / (self.areas * last).sum()
        return float(found)

    def fields(self) -> tuple[np.ndarray, np.ndarray]:
        """Return surface temperature [K] and shear stress [Pa] of every contact node [k] at the last row."""
        stress = self.shear()
        return (
            self._at_row(0, self.layers.surface_temperature()),
            np.where(stress > 0.0, self._at_row(1, stress), 0.0),
        )

    def _at_row(self, number: int, end: np.ndarray) -> np.ndarray:
        """Interpolate a value at the row between `_start[number]` before the kick and `end` after it."""
        if self._share == 1.0:
            return end
        return np.asarray(self._start[number] + self._share * (end - self._start[number]))

    def state(self, nodes: np.ndarray, part: slice) -> LayerState | None:
        """Return the layers at the end of a run; nodes [k]: in the user's numbering; part: their slice of all."""
        layers = self.layers
        numbers = layers.batches_of(part)
        if not numbers:
            return None
        waiting = self._waiting + self._pending()
        internal = {"waiting": waiting[part], "areas": self.areas[part], "substeps": np.array(self.substeps)}
        internal["used"] = np.searchsorted(numbers, layers.used[part])
        for place, number in enumerate(numbers):
            mine = layers.places(number, part)
            known = layers.batches[number].state().items()
            internal |= {f"{place}/{name}": values[mine] if np.ndim(values) else values for name, values in known}
        kinds = [layers.kinds[number] for number in numbers]
        warm, strain = (
            [layers.profiles(name, side)[part] for side in (0, 1)] for name in ("temperature", "plastic_strain")
        )
        two = any(kind.partner is not None for kind in kinds)
        return LayerState(
            nodes,
            layers.batches[0].depth,
            warm[0],
            strain[0],
            self.shear()[part],
            kinds[0].metal,
            tuple((kind.partner, kind.bodies) for kind in kinds),
            warm[1] if two else None,
            strain[1] if two else None,
            internal,
            tuple(kinds),
        )

    def start_from(self, nodes: np.ndarray, state: LayerState, part: slice) -> None:
        """Start from the layers of another run; contact nodes [k] without one there start with a new layer.

        part: their slice of all contact nodes; state: with the kinds of this scene (run/initial_layers.py).
        """
        layers, internal = self.layers, state.internal
        order = np.argsort(state.nodes)
        rows = order[np.minimum(np.searchsorted(state.nodes[order], nodes), len(order) - 1)]
        mine = np.flatnonzero(state.nodes[rows] == nodes)
        there = mine + part.start
        for number in layers.batches_of(part):
            if layers.kinds[number] in state.kinds:
                place = state.kinds.index(layers.kinds[number])
                begin = f"{place}/"
                known = {name[len(begin) :]: values for name, values in internal.items() if name.startswith(begin)}
                layers.batches[number].start_from(mine + layers.places(number, part).start, rows[mine], known)
                layers.used[there[internal["used"][rows[mine]] == place]] = number
        if self.partners is not None:  # what waits is that of the part of the area that was covered then
            self.partners.used = layers.used.copy()
            self.areas[there] = self.partners.areas[there] = internal["areas"][rows[mine]]
        self._waiting[there] = self._owed[there] = internal["waiting"][rows[mine]]
        taken = min(int(internal["substeps"]), self.model.substeps)
        self.substeps = max(self.substeps, taken) if self._taken_over else taken
        self._taken_over = True

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of this term and of its layers."""
        return [*super().owned(), *self.layers.owned()]
