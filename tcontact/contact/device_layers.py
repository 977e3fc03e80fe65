"""Friction layers that threads of a GPU step: what `LayeredFriction` keeps from step to step stands on the device."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..device import arrays
from ..device.launch import Prepared
from ..friction_layer import Layer, LayerState
from ..kernels import layer_places as at
from ..planning.device_lists import threads_of
from .layered_friction import LayeredFriction
from .term import ContactTerm

# numbers of the nodes and of all by the names of their attributes in `LayeredFriction`
NODE_NUMBERS = {
    at.WAITING: "_waiting",
    at.FRICTION_IMPULSE: "_friction_impulse",
    at.PRESSURE_IMPULSE: "_pressure_impulse",
    at.LAST: "_last",
    at.LAST_FORCE: "_force",
    at.KICK_WORK: "_kick_work",
    at.OWED: "_owed",
    at.GIVEN_BEFORE: "_given_before",
    at.POWER: "_power",
    at.WARMING: "_warming",
}
NODE_FLAGS = {at.PRESSED: "_pressed", at.SLID: "_slid"}
NUMBERS = {at.ERROR: "error", at.ELAPSED: "_elapsed", at.KICK: "_kick", at.SHARE: "_share"}
COUNTS = {at.SUBSTEPS: "substeps", at.SPAN: "span", at.COUNT: "_count"}
# numbers of a layer by their names in kernels/layer/layer1d_step.py
CELL_NUMBERS = {
    at.STRESS: "STRESS",
    at.CHANGE: "CHANGE",
    at.BEFORE: "BEFORE",
    at.CLOSE: "CLOSE",
    at.WORK: "WORK",
    at.PLASTIC: "PLASTIC_WORK",
}


class DeviceLayers:
    """The friction layers of a domain on a GPU (kernels/layer/device_layers.py).

    friction: what they limit, whose batches of layers the device steps; its other attributes are those of the start, or
    of the last `fetch`. control: what the device does next (kernels/step/device_control.py).
    rows [n, layer_places.ROW]: numbers of the rows of the last block.
    """

    def __init__(self, friction: LayeredFriction, contact: ContactTerm, control: arrays.Array) -> None:
        from ..kernels.language.bundles import Contact, DeviceLists, LayerCells, LayerOptions
        from ..kernels.language.joint_lists import joined
        from ..kernels.language.signatures import arguments, signature_of
        from ..kernels.step.device_layers import make_device_layers

        self.friction = friction
        layers = friction.layers
        self._count, self._entries = len(friction.areas), sum(len(nodes) for nodes in layers.nodes)
        self._lists = arrays.put(joined(self._parts()))
        self._tables = arrays.put(self._made_tables())
        self._numbers = arrays.zeros(
            at.HEAD + at.NODE * self._count + at.ENTRY * self._entries + len(friction._largest_work)
        )
        self._sent = False  # whether the device has the state of the host
        self.rows = np.zeros((0, len(at.ROW)))
        self.options = LayerOptions(layers.plain, friction.partners is not None)
        given = contact.arguments()
        kept = {name: given[name] for name in ("islands", "friction")}
        options = contact.options._replace(layers=self.options)
        self._launches = []
        first = 0
        for number, (batch, nodes) in enumerate(zip(layers.batches, layers.nodes, strict=True)):
            bundles = {
                "lists": DeviceLists(control=control),
                "contact": Contact(**kept, **self.arguments()),
                "own": LayerCells(**batch.arguments()),
            }
            made = make_device_layers(
                signature_of(bundles), options, batch.options, self._gives(number), threads_of(len(nodes))
            )
            self._launches.append((Prepared(made), (number, first, len(nodes)), arguments(bundles)))
            first += len(nodes)

    def _gives(self, number: int) -> int:
        """Return where the heat of slip of a batch goes that does not stay in the layer of the body."""
        kind = self.friction.layers.kinds[number]
        if kind.partner is None:
            return at.TO_NONE
        return at.TO_BODY if kind.bodies else at.TO_OBSTACLE

    def _given(self, number: int) -> np.ndarray:
        """Return the heat [J/m^2] that the layers of a batch have given to obstacles."""
        batch, gives = self.friction.layers.batches[number], self._gives(number)
        if gives == at.TO_NONE:
            return np.asarray((1.0 - batch.heat_share) * batch.cell("WORK"))
        return batch.cell("OTHER") if gives == at.TO_OBSTACLE else np.zeros(batch.cells)

    def _parts(self) -> list[np.ndarray]:
        """Return the lists of layer_places."""
        friction, layers = self.friction, self.friction.layers
        partners = np.zeros((1, 1)) if friction.partners is None else friction.partners.batches
        bodies, entries = len(friction._first), np.full((len(layers.batches), self._count), -1)
        places, place, first = [], 1, 0
        for number, (batch, nodes) in enumerate(zip(layers.batches, layers.nodes, strict=True)):
            entries[number, nodes] = first + np.arange(len(nodes))
            first += len(nodes)
            places.append(place)
            place += len(self._made_table(batch))
        sizes = [bodies, self._entries, len(layers.batches), partners.shape[1], layers.batches[0].points]
        parts = {
            at.SIZES: np.array(sizes),
            at.STARTS: np.append(friction._first, self._count),
            at.BODY_OF: friction._body if friction.partners is None else friction.partners.body,
            at.TABLES: np.array(places),
            at.SIDES: np.array([len(batch.metals) for batch in layers.batches]),
            at.PARTNERS: partners,
            at.NODE_OF: np.concatenate(layers.nodes),
            at.ENTRY_OF: entries,
        }
        return [parts[number] for number in range(at.LISTS)]

    def _made_tables(self) -> np.ndarray:
        """Return the tables of all batches, behind the step of their columns, which have none yet."""
        return np.concatenate([[0.0], *(self._made_table(batch) for batch in self.friction.layers.batches)])

    def _made_table(self, batch: Layer) -> np.ndarray:
        """Return the table of a batch: columns and parameters of any step, and what those of others come from."""
        columns, parameters = batch.constants(1.0)
        sides = [np.column_stack(side).reshape(-1) for side in batch.heat_constants()]
        return np.concatenate([columns, parameters, *sides, [batch.resistance]])

    def arguments(self) -> dict[str, arrays.Array]:
        """Return the arrays by the names of kernels/language/bundles.Contact."""
        return {"layers": self._numbers, "layer_lists": self._lists, "layer_tables": self._tables}

    def send(self) -> None:
        """Give the device the state of the host, if it has not got it."""
        if self._sent:
            return
        friction, layers = self.friction, self.friction.layers
        head = np.zeros(at.HEAD)
        for place, name in (NUMBERS | COUNTS).items():
            head[place] = getattr(friction, name)
        model = friction.model
        limits = model.tolerance, model.substeps, model.heat_share, model.plastic_heat
        head[[at.TOLERANCE, at.MOST_SUBSTEPS, at.HEAT_SHARE, at.PLASTIC_HEAT]] = limits
        head[[at.SOFTNESS, at.MELTING_RISE]] = friction._softness, friction._melting_rise
        nodes = np.zeros((at.NODE, self._count))
        for place, name in (NODE_NUMBERS | NODE_FLAGS).items():
            nodes[place] = getattr(friction, name)
        nodes[at.AREA], nodes[at.COEFFICIENT], nodes[at.USED] = friction.areas, friction.coefficients, layers.used
        nodes[at.START_RISE : at.START_GIVEN + 1] = friction._start
        nodes[at.START_RISE] -= model.initial_temperature
        entries = np.zeros((at.ENTRY, self._entries))
        for place, name in CELL_NUMBERS.items():
            entries[place] = np.concatenate([batch.cell(name) for batch in layers.batches])
        surfaces = [batch.surface_temperature() - model.initial_temperature for batch in layers.batches]
        entries[at.RISE] = np.concatenate(surfaces)
        entries[at.GIVEN] = np.concatenate([self._given(number) for number in range(len(layers.batches))])
        arrays.set_values(self._numbers, np.concatenate([head, nodes.ravel(), entries.ravel(), friction._largest_work]))
        self._sent = True

    def fetch(self) -> LayeredFriction:
        """Return the friction with the state of the device, if that has stepped the layers."""
        friction = self.friction
        if not self._sent:
            return friction
        values = np.array(arrays.get(self._numbers))
        nodes = self._nodes(values)
        for place, name in NUMBERS.items():
            setattr(friction, name, float(values[place]))
        for place, name in COUNTS.items():
            setattr(friction, name, int(values[place]))
        for place, name in NODE_NUMBERS.items():
            getattr(friction, name)[:] = nodes[place]
        for place, name in NODE_FLAGS.items():
            getattr(friction, name)[:] = nodes[place] > 0.0
        friction.layers.used[:] = nodes[at.USED]
        friction.coefficients = nodes[at.COEFFICIENT].copy()
        friction._start[:] = nodes[at.START_RISE : at.START_GIVEN + 1]
        friction._start[0] += friction.model.initial_temperature
        friction._largest_work[:] = values[len(values) - len(friction._largest_work) :]
        return friction

    def _nodes(self, values: np.ndarray) -> np.ndarray:
        """Return the numbers of the nodes [NODE, k]."""
        return values[at.HEAD :][: at.NODE * self._count].reshape(at.NODE, -1)

    def advance(self, kick: float) -> None:
        """Launch the layer steps of a mechanical step with a kick [s]."""
        for launch, numbers, given in self._launches:
            launch(*numbers, kick, *given)

    def row(self, late: float) -> dict[str, np.ndarray]:
        """Return the columns of the layers by name, for every row of the last block; late: the device has it."""
        found = dict(zip(at.ROW, self.rows.T, strict=True))
        found["layer_temperature_max"] = found["layer_temperature_max"] + self.friction.model.initial_temperature
        lowest = found["layer_shear_min"]
        found["layer_shear_min"] = np.where(lowest > 0.0, lowest, np.nan)
        return found

    def fields(self) -> tuple[np.ndarray, np.ndarray]:
        """Return surface temperature [K] and shear stress [Pa] as `LayeredFriction.fields`, with one copy."""
        if not self._sent:
            return self.friction.fields()
        values = np.array(arrays.get(self._numbers))
        nodes = self._nodes(values)
        entries = values[at.HEAD + nodes.size :][: at.ENTRY * self._entries].reshape(at.ENTRY, -1)
        layers, first = self.friction.layers, np.cumsum([0, *(len(part) for part in self.friction.layers.nodes)])
        layers.used[:] = nodes[at.USED]
        rise, stress = (
            layers.of_used([entries[place, first[i] : first[i + 1]] for i in range(len(layers.batches))])
            for place in (at.RISE, at.STRESS)
        )
        share, shear = values[at.SHARE], stress / np.sqrt(3.0)
        before = nodes[[at.START_RISE, at.START_SHEAR]]
        if share != 1.0:
            rise, at_row = (start + share * (end - start) for start, end in zip(before, (rise, shear), strict=True))
            shear = np.where(shear > 0.0, at_row, 0.0)
        return self.friction.model.initial_temperature + rise, shear

    def state(self, nodes: np.ndarray, part: slice) -> LayerState | None:
        """Return the layers at the end of a run as `LayeredFriction.state`."""
        return self.fetch().state(nodes, part)

    def start_from(self, nodes: np.ndarray, state: LayerState, part: slice) -> None:
        """Start from the layers of another run as `LayeredFriction.start_from`."""
        self.fetch().start_from(nodes, state, part)
        self._sent = False

    def kept(self) -> list[arrays.Array]:
        """Return the arrays from which a block of steps starts."""
        found: list[Any] = [self._numbers]
        for batch in self.friction.layers.batches:
            given = batch.arguments()
            found += [given[name] for name in given if name != "scratch"]
        return found

    def owned(self) -> list[arrays.Array]:
        """Return the arrays beside those of the layers themselves."""
        return [self._numbers, self._lists, self._tables]
