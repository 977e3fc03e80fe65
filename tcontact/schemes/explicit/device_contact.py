"""Blocks of steps of a domain with contact on a GPU, where one block of threads takes the boundary nodes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...cells.device_force import DeviceForce
from ...cells.device_viscosity import DeviceCellViscosity
from ...contact.bundles import rigid_bundle, support_bundle
from ...contact.massless_contact import MasslessContactTerm
from ...device import arrays
from ...device.launch import Prepared
from ...kernels.columns import SUMS
from ...kernels.lanes import BLOCK_THREADS
from ...kernels.sweep_places import STATE
from ...nodes.boundary_nodes import BoundaryNodes, Supports
from ...nodes.rigid_bodies import RigidBodies
from ...planning.device_blocks import contact_blocks, partial_numbers, sweep_colours
from ...planning.device_lists import colour_lists, parts_of, residual_donors, surface_corners, surface_threads
from ...planning.domain import Domain
from . import device_offers
from .device_sweeps import DeviceSweeps
from .device_terms import DeviceTermSteps, Shared

KERNELS = 6  # that a launch of a step or a pass starts, about
FEWEST_PASSES = 2  # of the static solve that a step of the first block offers
MORE_PASSES = 4  # offered at once where a solve goes on at the end of a block


class DeviceContactSteps(DeviceTermSteps):
    """Steps in blocks as `DeviceSteps`, of a domain with massless contact nodes and obstacles.

    A step offers passes of the static solve by what the steps of the last block needed (device_offers.py); a solve that
    needs more takes those of the next step (kernels/step/device_control.py).
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
        shared: Shared | None = None,
    ) -> None:
        from ...kernels.language.signatures import arguments, signature_of
        from ...kernels.step import device_contact

        options = contact.options._replace(threads=BLOCK_THREADS)
        blocks = contact_blocks(domain, options)
        colours = sweep_colours(domain, contact.static_solve.islands, blocks, options)
        super().__init__(domain, groups, force, u, v, boundary, contact, shared, contact.viscous, blocks)
        if self.layers is not None:
            options = options._replace(layers=self.layers.options)
        self.contact, self._cells = contact, contact.cell_viscosity
        self.boundary_nodes, self.inverse_mass = boundary.nodes, boundary.inverse_mass
        self.passes = FEWEST_PASSES
        self._make_arrays(domain, blocks, colours)
        self._bundles = step, start, solved = self._make_bundles(u, v, boundary, supports, rigid)
        self._parts = tuple(arguments(bundles) for bundles in self._bundles)
        exact, threads = contact.exact and contact.pairs is None, surface_threads(force.packs)
        surfaces = {block.kind for block in domain.blocks if len(block.contact)}
        measured = tuple(i for i, kind in enumerate(domain.kinds) if kind in surfaces)
        has = exact, supports is not None, bool(domain.driven), bool(domain.springs)
        cells = (measured, threads) if contact.viscous else ((), 0)
        of_step = domain.kinds, signature_of(step), force.threads, options, *has, *cells
        options_of = domain.options | {"loaded": self.loads.name, "blocks": blocks}
        made = device_contact.make_device_contact_step
        self._steps = self._launches(lambda stages: made(*of_step, **options_of, stages=stages))
        self._start = Prepared(device_contact.make_device_start(signature_of(start), options, exact))
        of_pass = domain.kinds, measured, signature_of(solved), threads, options, contact.plain, blocks, colours
        self._pass = Prepared(device_contact.make_device_pass(*of_pass))
        self._sweeps = None
        if colours:
            swept = start["lists"], solved["contact"], solved["system"]
            self._sweeps = DeviceSweeps(swept, solved["body"], options, blocks, colours)
        if self._cells is not None:
            self._make_viscous_pass(domain.kinds, measured, threads)
        self._keep_terms(contact, rigid)
        system = contact.static_solve.system
        self._keep([contact.displacement_before, contact.active])
        self._keep([system[name] for name in ("values", "inverse", "stiffness", "stats")])
        self._keep([] if rigid is None else [contact.static_solve.pairs["values"]])
        self._keep([] if self._cells is None else [self._cells.data])

    def _make_arrays(self, domain: Domain, blocks: int, colours: int) -> None:
        """Make the lists and numbers of threads that share the static solve; colours: of `sweep_colours`."""
        assert domain.contact is not None
        assert domain.contact.graph is not None
        solve, own = self.contact.static_solve, self._own
        packs = arrays.get(solve.system["pack_start"])
        own["residual_donors"] = arrays.put(residual_donors(*domain.residual_receivers, len(domain.boundary)))
        own["residual_shares"] = arrays.zeros(3 * len(domain.contact.nodes))
        own["colours"] = arrays.put(colour_lists(domain.contact.graph, solve.islands, packs))
        own["contact_parts"] = arrays.put(parts_of(self.force.packs, domain, contact=True))
        own["corner_rows"] = arrays.put(self._corners(self.force, domain))
        if blocks > 1:
            own["partial"] = arrays.zeros(blocks * partial_numbers(self.width, len(solve.islands), colours))
        if colours:
            own["sweep_state"] = arrays.zeros(STATE * len(solve.islands))

    def _make_bundles(
        self,
        u: arrays.Array,
        v: arrays.Array,
        boundary: BoundaryNodes,
        supports: Supports | None,
        rigid: RigidBodies | None,
    ) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
        """Return the bundles of a step, of the start of a run, and of a pass of the static solve."""
        from ...kernels.language.bundles import Launch
        from ...kernels.language.solve_bundles import Pairs, System

        force, contact, own = self.force, self.contact, self._own
        solve = contact.static_solve
        shared = "residual_donors", "residual_shares", "partial"
        terms = self._term_bundles(boundary, contact, **{name: own[name] for name in shared if name in own})
        body = force.device_bundle()._replace(u=u, v=v)
        stepped = body._replace(node_info=force.info, special_force=force.special_force)
        surface = body._replace(v=None, mass=None, rows=force.corner_forces, corner_rows=own["corner_rows"])
        if contact.options.static_friction and (contact.options.varied or contact.options.coupled):
            surface = surface._replace(v=v)  # of rows that get a new partner in the solve, of masters
        lists = force.lists._replace(control=own["control"])
        controlled = type(lists)(control=own["control"])
        passed = controlled._replace(corner_forces=lists.corner_forces, contact_parts=own["contact_parts"])
        launch = Launch()
        if self._cells is not None:
            launch = Launch(viscous_cells=self._cells.data)
            lists = lists._replace(contact_parts=own["contact_parts"])
            stepped = stepped._replace(corner_rows=own["corner_rows"])
            surface = surface._replace(node_info=force.info)
        system = System(**solve.system, colours=own["colours"], sweep_state=own.get("sweep_state"))
        measures = System(stiffness=system.stiffness, settings=system.settings, stats=system.stats)
        if contact.pairs is not None:  # which look for squeezed nodes
            measures = measures._replace(gaps=system.gaps, normals=system.normals, response=system.response)
        pairs = Pairs()
        if rigid is not None:  # the rate of its obstacles needs the stiffness of the contact cells
            pairs = Pairs(**{name: solve.pairs[name] for name in ("row_start", "entries", "entry_pairs", "values")})
        step = {
            "body": stepped,
            "lists": lists,
            "boundary": terms["boundary"],
            "supports": support_bundle(supports, own["sums"]),
            **terms,
            "pairs": pairs,
            "system": measures,
            "rigid": rigid_bundle(rigid, own["sums"]),
            "launch": launch,
        }
        start = {"body": stepped, "lists": controlled, **terms, "launch": launch}
        solved = {"body": surface, "lists": passed, **terms, "pairs": Pairs(**solve.pairs), "system": system}
        return step, start, solved | {"launch": launch}

    def _make_viscous_pass(self, kinds: tuple[tuple[str, str], ...], measured: tuple[int, ...], threads: int) -> None:
        """Make the launch of the viscous contact cells alone; arguments as of its kernel."""
        from ...kernels.language.signatures import signature_of
        from ...kernels.step.device_surface import make_device_viscous_pass

        solved = self._bundles[2]
        self._of_cells = {
            "body": solved["body"]._replace(corner_rows=None, rows=None),
            "lists": type(solved["lists"])(contact_parts=self._own["contact_parts"]),
            "launch": solved["launch"],
        }
        self._viscous_pass = Prepared(make_device_viscous_pass(kinds, measured, signature_of(self._of_cells), threads))

    def _corners(self, force: DeviceForce, domain: Domain) -> np.ndarray:
        """Return the corners of the contact nodes, with viscous cells those of their cells at all boundary nodes."""
        places = arrays.get(force.node_corners)
        if self._cells is not None:
            return surface_corners(places, domain.boundary, self._cells.first_place())
        assert domain.contact is not None
        return surface_corners(places, domain.contact.nodes)

    def viscous_force(self, u: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return the viscous force [3n] of a small step [3n] to u [3n] times its duration; 0 without viscous cells."""
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
            self.count_steps(control)
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

    def _learn(self, control: np.ndarray, taken: int) -> None:
        """Offer from now on what would have cost least for the rows that this block has taken so far."""
        names, (step, _start, one) = self.names, (float(len(part) + KERNELS) for part in self._parts)
        costs = [one]
        if self._sweeps is not None:
            steps, most = self._rows_of(control, taken)[:, SUMS.sweeps], control[names.MOST_SWEEPS : names.SOLVES]
            self._sweeps.needed(steps, most, step + self.passes * one)
            costs = [one + cost for cost in self._sweeps.costs]
        self.passes = device_offers.passes(control[names.SOLVES : names.DEVICE_CONTROL], step, costs)

    def take(self, kicks: tuple[float, float, float], steps: tuple[float, float], rows: int) -> np.ndarray:
        """Take up to `rows` steps, fewer where a static solve does not converge; return their raw rows."""
        self._begin_pairs()
        if steps[1] > 0.0:
            self.force.set_solved_step(steps[1])
        names, offer, taken = self.names, 0, 0
        while taken < rows:  # again where solves needed more than was offered, which is known then
            for _ in range(rows - taken):
                self._launch_step(offer, kicks, steps)
                offer += 1
                for number in range(self.passes if steps[1] > 0.0 else 0):
                    self._offer_pass(number)
            built = self.rows_built
            control = self._settle()
            taken = int(control[names.TAKEN])
            self._learn(control, taken)
            if control[names.WANTS] == names.A_LOOK or self.rows_built != built:
                break
        self._pass_over(rows - taken)
        boundary = self._rows_of(control, taken)
        found = self.force.ledger_rows(taken)
        if self._cells is not None:  # no rate of theirs is watched: the search for the stable step knows them
            viscous = np.stack([boundary[:, self.width], np.zeros(taken)], axis=1)
            found = np.insert(found, [self._places.cells.viscous_power] * 2, viscous, axis=1)
        return np.concatenate([found, boundary[:, : self.width]], axis=1)
