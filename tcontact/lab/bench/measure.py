"""Measurement of one configuration: the step with and without contact, its parts, the plain step, a copy, in turns."""

from __future__ import annotations

import gc
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ...device import arrays, runtime
from ...device.launch import Prepared
from ...planning.domain import Domain
from ...planning.planning import plan
from ...results.result import Result
from ...run.simulation import simulate
from ...scene.scene import Scene
from ...schemes.explicit.state import DomainState
from . import accuracy, blocks, timing
from .bare import without_energy
from .configuration import Configuration
from .parts import parts_of_a_step
from .plain_step import PlainStep, make_copy
from .rows import rows_of

BATCH = 3e6  # hex cell updates in a batch, about
# cells that take as long as a hex, about
WEIGHT = {"hex8": 1, "hex8-reduced": 3, "hex8-mean-dilatation": 1, "tet4": 5, "wedge6": 1}
COMPARED = 5  # steps after which the plain step must stand where ours does


class WholeStep:
    """Runs of a scene by the public `simulate`, a row of history every step; `result` is the last one."""

    def __init__(self, configuration: Configuration, contact: str, steps: int | None) -> None:
        self.result: Result | None = None
        names = ("threads", "arch", "precision")
        self._options: dict[str, Any] = {name: getattr(configuration, name) for name in names}
        few = self._run(blocks.block(configuration.kind, configuration.law, configuration.size, contact))
        if steps is None:
            fast = WEIGHT[configuration.element] * BATCH / configuration.cells
            steps = int(np.clip(fast, 10, max(10, 3 * configuration.size)))
        self.scene: Scene = replace(few.scene, duration=(steps - 0.5) * few.dt)
        self.dt = few.dt

    def _run(self, scene: Scene) -> Result:
        result = simulate(scene, **self._options)
        if not result.ok:
            raise RuntimeError(f"{result.reason}: {result.message}")
        return result

    def __call__(self) -> float:
        """Run the scene from its start; return seconds a step, the first one (which would compile) not counted."""
        gc.collect()
        self.result = self._run(self.scene)
        return self.result.wall_s / self.result.steps


def measure(configuration: Configuration) -> dict[str, Any]:
    """Return the rows of a configuration, and what was measured beside them."""
    runtime.start(configuration.arch, configuration.threads)
    load = timing.load()
    mixed = configuration.precision == "mixed"
    errors = accuracy.step_errors(configuration.kind, configuration.law, configuration.size, mixed)
    free = WholeStep(configuration, "none", configuration.steps)
    steps = round(free.scene.duration / free.dt + 0.5)
    whole: dict[str, WholeStep] = {"none": free}
    failures: dict[str, str] = {}
    for contact in configuration.contacts:
        if contact not in whole:
            try:
                whole[contact] = WholeStep(configuration, contact, steps)
            except Exception as error:  # a row with its reason; the others go on
                failures[contact] = f"{type(error).__name__}: {error}"
    works: dict[str, timing.Work] = {f"step {contact}": run for contact, run in whole.items()}
    others = Comparisons(free, configuration, steps)
    taken = timing.rounds(works | others.works, configuration.seconds, configuration.batches)
    calls: dict[str, dict[str, float]] = {contact: {} for contact in whole}
    precision = configuration.precision
    parts = {contact: parts_of_a_step(run.scene, precision, calls[contact]) for contact, run in whole.items()}
    found = others.facts | errors | {"load": [load, timing.load()], "steps": steps}
    results = {contact: run.result for contact, run in whole.items() if run.result is not None}
    return {"rows": rows_of(configuration, taken, results, parts, found, failures, calls)}


class Comparisons:
    """Works that the whole step is compared with: our kernel alone, the plain step, a copy."""

    def __init__(self, free: WholeStep, configuration: Configuration, steps: int) -> None:
        scene, dt = free.scene, free.dt
        body = plan(scene).bodies[0]
        zero, velocity = np.zeros((len(body.reference), 3)), scene.bodies[0].initial_velocity
        finish = runtime.load().sync
        domain = Domain((body,))
        domain.mixed = configuration.precision == "mixed"
        state = DomainState(scene, domain, [zero], [velocity])
        plain = PlainStep(body, zero, velocity[body.node_order], dt)
        force = state.internal_force
        exact = state if not domain.mixed else DomainState(scene, Domain((body,)), [zero], [velocity])
        bare = without_energy(exact.internal_force, body.variant, body.body.material.law)

        def ours() -> None:
            force.advance(state.u, state.v, dt / 2, dt / 2, dt)

        def no_energy() -> None:
            bare.advance(state.u, state.v, dt / 2, dt / 2, dt)

        for _ in range(COMPARED):
            ours()
            plain.step()
        here, there = np.array(arrays.get(state.u)), np.array(arrays.get(plain.u))
        no_energy()
        self.facts: dict[str, Any] = {
            "plain_error": accuracy.difference(here, there),
            "plain_bytes_per_cell": plain.size_in_bytes() / configuration.cells,
        }
        self.works: dict[str, timing.Work] = {
            "kernel": timing.batch(ours, steps, finish),
            "plain": timing.batch(plain.step, steps, finish),
            "copy": timing.host_copy(configuration.threads) if configuration.arch == "cpu" else _device_copy(finish),
        }
        if not state.domain.small and not domain.mixed:  # a small one takes many steps a launch and has no such kernel
            self.works["no energy"] = timing.batch(no_energy, steps, finish)


def _device_copy(finish: Callable[[], object]) -> timing.Work:
    """Return the work of a copy kernel on the device, in seconds per byte moved."""
    source, target = arrays.zeros(timing.COPY_BYTES // 8), arrays.zeros(timing.COPY_BYTES // 8)
    copy = Prepared(make_copy())
    work = timing.batch(lambda: copy(source, target), 10, finish)
    work()
    return lambda: work() / (2 * timing.COPY_BYTES)
