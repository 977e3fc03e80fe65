"""Blocks of steps of a domain with contact on a GPU, where one block of threads takes the boundary nodes."""

from __future__ import annotations

import numpy as np

from ...cells.device_force import DeviceForce
from ...cells.device_viscosity import DeviceCellViscosity
from ...contact.device_layers import DeviceLayers
from ...contact.layered_friction import LayeredFriction
from ...contact.massless_contact import MasslessContactTerm
from ...device import arrays
from ...device.launch import Prepared
from ...kernels.columns import group_size
from ...kernels.lanes import BLOCK_THREADS, DEVICE_ROWS
from ...kernels.sweep_places import STATE
from ...nodes.boundary_nodes import BoundaryNodes, Supports
from ...nodes.rigid_bodies import RigidBodies
from ...planning.device_blocks import contact_blocks, partial_numbers, scratch, sweep_colours
from ...planning.device_lists import colour_lists, parts_of, residual_donors, surface_corners, surface_threads
from ...planning.domain import Domain
from .device_loads import DeviceLoads
from .device_pairs import pair_arguments
from .device_step import LAYERS, DeviceSteps
from .device_sweeps import DeviceSweeps

FEWEST_PASSES = 2  # of the static solve that a step of the first block offers
MORE_PASSES = 4  # offered at once where a solve goes on at the end of a block


class DeviceContactSteps(DeviceSteps):
    """Steps in blocks as `DeviceSteps`, of a domain with massless contact nodes and obstacles.

    A step offers as many passes of the static solve as a step of the last block needed; a solve that needs more takes
    those of the next step (kernels/step/device_control.py). groups: of the columns in its raw rows.
    """

    def __init__(
        self,
        domain: Domain,
        groups: tuple[str, ...],
        force: DeviceForce,
        u: arrays.Array,
        v: arrays.Array,
        boundary: BoundaryNodes,
        contact: MasslessContactTerm,
        supports: Supports | None = None,
        rigid: RigidBodies | None = None,
    ) -> None:
        from ...kernels.language.bundles import Boundary, Contact, Launch, Obstacles, Rigid, Rows
        from ...kernels.language.bundles import Supports as SupportArrays
        from ...kernels.language.signatures import arguments, signature_of
        from ...kernels.language.solve_bundles import Pairs, System
        from ...kernels.step import device_contact, device_control, device_surface

        super().__init__(force, u, v, contact.viscous)
        self.names, self.contact = device_control, contact
        assert domain.contact is not None
        assert domain.contact.graph is not None
        solve, options = contact.static_solve, contact.options._replace(threads=BLOCK_THREADS)
        layered = isinstance(contact.friction, LayeredFriction)
        count, everyone = len(domain.contact.nodes), len(domain.boundary)
        self.width = group_size(*groups[groups.index("boundary") :])
        self._cells = contact.cell_viscosity
        self.boundary_nodes, self.inverse_mass = boundary.nodes, boundary.inverse_mass
        self.passes = FEWEST_PASSES
        blocks = contact_blocks(domain, options)
        most_colours = sweep_colours(domain, solve.islands, blocks, options)
        colours = colour_lists(domain.contact.graph, solve.islands, arrays.get(solve.system["pack_start"]))
        own = self._own = {
            "sums": arrays.zeros(self.width),
            "shared": arrays.zeros(scratch(blocks)),
            "residual_donors": arrays.put(residual_donors(*domain.residual_receivers, everyone)),
            "residual_shares": arrays.zeros(3 * count),
            "colours": arrays.put(colours),
            "contact_parts": arrays.put(parts_of(force.packs, domain, contact=True)),
            "control": arrays.zeros(device_control.DEVICE_CONTROL + DEVICE_ROWS * (self._row_width + layered * LAYERS)),
            "corner_rows": arrays.put(self._corners(force, domain)),
        }
        if blocks > 1:
            numbers = partial_numbers(self.width, len(solve.islands), most_colours)
            own["partial"] = arrays.zeros(blocks * numbers)
        if isinstance(contact.friction, LayeredFriction):
            self.layers = DeviceLayers(contact.friction, contact, own["control"])
            options = options._replace(layers=self.layers.options)
        loads = self.loads = DeviceLoads(domain, force, u, boundary)
        lists = force.lists._replace(contact_parts=own["contact_parts"], control=own["control"])
        shared = "sums", "shared", "residual_donors", "residual_shares", "partial"
        shares = {name: own[name] for name in shared if name in own}
        shares |= self.layer_arguments() | pair_arguments(contact.pairs)
        common = {
            "boundary": Boundary(**boundary.arguments(), **loads.arguments(), sums=own["sums"]),
            "obstacles": Obstacles(**contact.obstacle_arguments()),
            "rows": Rows(**contact.row_arguments()),
            "contact": Contact(**contact.arguments(), **shares),
        }
        body = force.device_bundle()._replace(u=u, v=v)
        stepped = body._replace(node_info=force.info, special_force=force.special_force)
        surface = body._replace(v=None, mass=None, rows=force.corner_forces, corner_rows=own["corner_rows"])
        if options.static_friction and (
            options.varied or options.coupled
        ):  # of rows that get a new partner in the solve, of masters
            surface = surface._replace(v=v)
        if most_colours:
            own["sweep_state"] = arrays.zeros(STATE * len(solve.islands))
        system = System(**solve.system, colours=own["colours"], sweep_state=own.get("sweep_state"))
        measures = System(stiffness=system.stiffness, settings=system.settings, stats=system.stats)
        if contact.pairs is not None:  # which look for squeezed nodes
            measures = measures._replace(gaps=system.gaps, normals=system.normals, response=system.response)
        held = SupportArrays() if supports is None else SupportArrays(**supports.arguments(), sums=own["sums"])
        stepping, launch = lists._replace(contact_parts=None), Launch()
        if self._cells is not None:
            launch = Launch(viscous_cells=self._cells.data)
            stepping, stepped = lists, stepped._replace(corner_rows=own["corner_rows"])
            surface = surface._replace(node_info=force.info)
        first = {"body": stepped, "lists": stepping, "boundary": common["boundary"]}
        free, pairs = Rigid(), Pairs()
        if rigid is not None:  # the rate of its obstacles needs the stiffness of the contact cells
            free = Rigid(**rigid.arguments(), sums=own["sums"])
            pairs = Pairs(**{name: solve.pairs[name] for name in ("row_start", "entries", "entry_pairs", "values")})
        step = {**first, "supports": held, **common, "pairs": pairs, "system": measures, "rigid": free}
        step |= {"launch": launch}
        controlled = type(lists)(control=own["control"])
        start = {"body": stepped, "lists": controlled, **common, "system": measures, "launch": launch}
        kept = ("corner_forces", "contact_parts", "control")
        passed = type(lists)(**{name: getattr(lists, name) for name in kept})
        solved = {"body": surface, "lists": passed, **common, "pairs": Pairs(**solve.pairs), "system": system}
        solved |= {"launch": launch}
        surfaces = {block.kind for block in domain.blocks if len(block.contact)}
        measured = tuple(i for i, kind in enumerate(domain.kinds) if kind in surfaces)
        threads = surface_threads(force.packs)
        exact, options_of = contact.exact and contact.pairs is None, domain.options
        made = device_contact.make_device_contact_step
        has = exact, supports is not None, bool(domain.driven), bool(domain.springs)
        cells = (measured, threads) if contact.viscous else ((), 0)
        parts = domain.kinds, signature_of(step), force.threads, options, *has, *cells
        options_of = options_of | {"loaded": loads.name, "blocks": blocks}
        self._steps = self.parts_of_step(lambda part: made(*parts, **options_of, part=part))
        self._start = Prepared(device_contact.make_device_start(signature_of(start), options, exact))
        of_pass = domain.kinds, measured, signature_of(solved), threads, options, contact.plain, blocks, most_colours
        self._pass = Prepared(device_contact.make_device_pass(*of_pass))
        self._sweeps = None
        if most_colours:
            swept = controlled, common["contact"], system
            self._sweeps = DeviceSweeps(swept, surface, common["rows"], options, blocks, most_colours)
        self._bundles = step, start, solved
        self._parts = tuple(arguments(bundles) for bundles in self._bundles)
        self.watch_pairs(contact.pairs, u)
        names = "values", "inverse", "stiffness", "stats"
        self._keep([] if self.layers is None else self.layers.kept())
        self._keep([contact.displacement_before, contact.active, *(solve.system[name] for name in names)])
        self._keep([contact.candidates, *([contact.obstacles.records] if contact.obstacles.posed else [])])
        if contact.friction is not None:
            assert contact.rows is not None
            self._keep([contact.rows.values, contact.friction.data])
        if loads.name:
            self._keep(loads.kept)
        if rigid is not None:
            self.watch(groups)
            self._keep([rigid.values, *([] if contact.obstacles.posed else [contact.obstacles.records])])
            self._keep([solve.pairs["values"]])
        if self._cells is not None:
            self._keep([self._cells.data])
            of_cells = surface._replace(corner_rows=None, rows=None)
            alone = {"body": of_cells, "lists": type(lists)(contact_parts=own["contact_parts"]), "launch": launch}
            made = device_surface.make_device_viscous_pass(domain.kinds, measured, signature_of(alone), threads)
            self._viscous_pass, self._of_cells = Prepared(made), alone

    @property
    def _row_width(self) -> int:
        """Numbers of a row that the device keeps: of the boundary nodes, the power of viscous cells, of the layers."""
        return self.width + (self._cells is not None) + (0 if self.layers is None else LAYERS)

    def _corners(self, force: DeviceForce, domain: Domain) -> np.ndarray:
        """Return the corners of the contact nodes, with viscous cells those of their cells at all boundary nodes."""
        places = arrays.get(force.node_corners)
        if self._cells is not None:
            return surface_corners(places, domain.boundary, self._cells.first_place())
        assert domain.contact is not None
        return surface_corners(places, domain.contact.nodes)

    def viscous_force(self, u: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Viscous force [3n] of a small step [3n] to u [3n], times its length in time; 0 without viscous cells."""
        return np.zeros_like(u) if self._cells is None else self._cells.product(u, step, self.measure_viscous)

    def measure_viscous(self, present: arrays.Array) -> None:
        """Put the viscous corner forces of a step that ends at the displacement `present` into those data."""
        from ...kernels.language.signatures import arguments

        body = self._of_cells["body"]._replace(u=present)
        self._viscous_pass(*arguments(self._of_cells | {"body": body}))

    @property
    def cells(self) -> DeviceCellViscosity:
        """The viscous contact cells, where there are any."""
        assert isinstance(self._cells, DeviceCellViscosity)
        return self._cells

    @property
    def corner_rows(self) -> arrays.Array:
        """Corners of the contact cells at every boundary node, with viscous ones."""
        return self._own["corner_rows"]

    def begin(self) -> None:
        """Bring the massless nodes to equilibrium at the start."""
        self._start(*self._parts[1])
        self._settle()

    def _offer_pass(self, number: int, times: int = 1) -> None:
        """Offer pass `number` of a step; times: as many sweeps as usual, where they are launched one by one."""
        self._pass(*self._parts[2])
        if self._sweeps is not None:
            self._sweeps.offer(number, times)

    def _settle(self) -> np.ndarray:
        """Offer passes until the static solve has ended; return the numbers of the device."""
        names = self.names
        for turn in range(99):
            control = np.array(arrays.get(self._own["control"]))
            if control[names.WANTS] == names.A_ROWS:
                self.build_rows()
                control[names.WANTS] = names.A_PASS
                arrays.set_values(self._own["control"], control)
            if control[names.WANTS] != names.A_PASS:
                break
            for _ in range(MORE_PASSES):
                self._offer_pass(0, 1 << min(turn, 8))
        if control[names.WANTS] == names.A_LOOK:  # the host has seen it
            after = control.copy()
            after[names.WANTS] = names.NOTHING
            arrays.set_values(self._own["control"], after)
        return control

    def _take(self, kicks: tuple[float, float, float], steps: tuple[float, float], rows: int) -> np.ndarray:
        """Take up to `rows` steps, fewer where a static solve does not converge; return their raw rows."""
        self.begin_pairs()
        names, offer, taken = self.names, 0, 0
        commit = int(self.force.memory is not None)
        numbers = [float(number) for number in (steps[0], *kicks, *self.force.gravity, steps[1])]
        while taken < rows:
            for _ in range(rows - taken):
                self.launch_step(offer, commit, numbers, self._parts[0])
                offer += 1
                for number in range(self.passes if steps[1] > 0.0 else 0):
                    self._offer_pass(number)
            built = self.rows_built
            control = self._settle()
            taken = int(control[names.TAKEN])
            if control[names.WANTS] == names.A_LOOK or self.rows_built != built:
                break
        self.passes = max(1, int(control[names.MOST_PASSES]))
        if self._sweeps is not None:
            self._sweeps.needed(control[names.MOST_SWEEPS : names.DEVICE_CONTROL])
        boundary = control[names.DEVICE_CONTROL :].reshape(-1, self._row_width)[:taken]
        self.note_layers(boundary)
        found = self.force.ledger_rows(taken)
        if self._cells is not None:  # no rate of theirs is watched: the search for the stable step knows them
            viscous = np.stack([boundary[:, self.width], np.zeros(taken)], axis=1)
            found = np.insert(found, [self._places.cells.viscous_power] * 2, viscous, axis=1)
        return np.concatenate([found, boundary[:, : self.width]], axis=1)

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the steps beside those of their terms."""
        layers = [] if self.layers is None else self.layers.owned()
        return [*super().owned(), *self._own.values(), *self.loads.owned(), *layers]
