"""arch="cuda": a run that cannot be made there is refused before anything is started or written, with the reason."""

import numpy as np
import pytest
from scenes import block

import tcontact as tc
from tcontact.cases import cube_impact
from tcontact.cells.device_force import DeviceForce
from tcontact.commands import devices
from tcontact.device import arrays, cuda, runtime
from tcontact.planning.planning import plan
from tcontact.run import device_room
from tcontact.run.simulation import simulate
from tcontact.schemes import IMPLICIT
from tcontact.schemes.explicit.device_memory import domain_size, plan_bytes
from tcontact.schemes.explicit.device_stable_step import DeviceStableSteps
from tcontact.schemes.explicit.device_step import DeviceSteps
from tcontact.schemes.explicit.stable_step import StableStep

SOFT = tc.NeoHookean(2.3e7, 0.27, 1350.0)
METAL = tc.ElastoPlastic(7e10, 0.33, 2700.0, tc.LinearHardening(1e8, 1e9), specific_heat=900.0)


def scene(mesh=None, material=SOFT):
    return tc.Scene([tc.Body(block(cells=2) if mesh is None else mesh, material)], [], 1e-3, contact=None)


def device(free, total=2**40):
    return cuda.Device("small card", 1, total, free)


@pytest.mark.parametrize(
    ("mesh", "material"),
    [(block(cells=(5, 4, 3)), SOFT), (block("tet4", 3), SOFT), (block("wedge6", 2), SOFT), (block(cells=3), METAL)],
)
def test_the_bytes_of_a_body_are_those_of_its_arrays(parallel_path, mesh, material):
    """Up to tables of a few numbers; the arrays are those that a GPU gets, made in host memory here."""
    (domain,) = plan(scene(mesh, material)).domains
    size, force = domain_size(domain), DeviceForce(domain)
    u, v = (arrays.zeros(3 * len(domain.reference)) for _ in range(2))
    assert 0 <= arrays.size_in_bytes(force.owned()) - size.force < 500
    assert arrays.size_in_bytes([u, v]) == size.state
    assert arrays.size_in_bytes(DeviceSteps(force, u, v).owned()) == size.kept
    growing = [force.corner_forces, force.reference, *([] if force.memory is None else [force.memory])]
    assert size.places == max(one.size for one in growing)


def test_the_bytes_of_the_search_are_those_of_its_arrays(parallel_path):
    (domain,) = plan(scene(block(cells=(5, 4, 3)))).domains
    search = DeviceStableSteps(DeviceForce(domain), [StableStep(body, [], None) for body in domain.bodies])
    kept = [one for body in search._kept for one in body]
    taken = arrays.size_in_bytes([search.trial, search.answer, search.start, *search._scratch, *kept])
    assert 0 <= taken - domain_size(domain).search < 1000


def test_what_doctor_says_fits_is_what_a_plan_takes(monkeypatch):
    for variant, kind in {"hex8": "hex8", "tet4-stored": "tet4"}.items():
        (domain,) = plan(scene(block(kind, 5))).domains
        assert devices.box_size(variant, 5) == domain_size(domain)
        room = 3 * 2**30
        largest = devices.largest_box(variant, room)
        taken = [devices.box_size(variant, largest + more).total + device_room.RESERVE for more in (0, 1)]
        assert taken[0] <= room < taken[1]
    assert devices.largest_box("hex8", 2**45) == 447  # 24 numbers of a cell are counted in 32 bits
    assert devices.largest_box("hex8", 2**20) == 0
    monkeypatch.setattr(cuda, "find_device", lambda: device(3 * 2**30, 4 * 2**30))
    lines = devices.cuda_lines()
    assert lines[0] == "1 device(s), first: small card, 4 GiB, 3 GiB of it free; use --arch cuda"
    largest = devices.largest_box("hex8", 3 * 2**30)
    assert lines[1].startswith(f"fits {largest}^3 boxes, {largest**3} cells of hex8")
    assert lines[1].endswith("(by its memory)")
    monkeypatch.setattr(cuda, "find_device", lambda: device(2**29))
    assert "too little free memory for a body of hex8" in devices.cuda_lines()[1]


def test_a_run_that_does_not_fit_is_refused_before_it_starts(monkeypatch, tmp_path):
    """By one byte; the message has the bytes, and how large a mesh would fit."""
    runtime.start()
    asked, started = cube_impact.scene(cells=2), []
    needed = plan_bytes(tc.plan(asked)) + device_room.RESERVE
    monkeypatch.setattr(cuda, "find_device", lambda: device(needed - 1))
    monkeypatch.setattr(runtime, "start", lambda *options: started.append(options))
    with pytest.raises(tc.InputError) as caught:
        simulate(asked, arch="cuda", out=tmp_path / "run", frames=3)
    assert caught.value.field == "arch"
    for part in (f"needs {needed} bytes", f"has {needed - 1}", "small card", "cells", "arch='cpu'"):
        assert part in caught.value.remedy
    assert not started
    assert not (tmp_path / "run").exists()
    device_room.check_device(tc.plan(asked), "cpu")
    monkeypatch.setattr(cuda, "find_device", lambda: device(needed))
    device_room.check_device(tc.plan(asked), "cuda")


def test_numbers_that_32_bits_cannot_count_are_refused(monkeypatch):
    planned = tc.plan(scene())
    (domain,) = planned.domains
    monkeypatch.setattr(cuda, "find_device", lambda: device(2**40))
    monkeypatch.setattr(device_room, "PLACES", domain_size(domain).places)
    device_room.check_device(planned, "cuda")
    monkeypatch.setattr(device_room, "PLACES", domain_size(domain).places - 1)
    with pytest.raises(tc.InputError, match=f"would have {domain_size(domain).places}"):
        device_room.check_device(planned, "cuda")


def test_no_device_is_said_with_the_reason(monkeypatch, tmp_path):
    def none():
        raise cuda.NoDevice("no driver (libcuda.so is not there)")

    monkeypatch.setattr(cuda, "find_device", none)
    with pytest.raises(tc.InputError, match=r"no usable CUDA device was found: no driver .*; use arch='cpu'"):
        simulate(scene(), arch="cuda", out=tmp_path / "run")
    assert not (tmp_path / "run").exists()
    assert devices.cuda_lines() == ["not usable: no driver (libcuda.so is not there); --arch cpu is left"]


@pytest.mark.parametrize("scheme", IMPLICIT)
def test_implicit_schemes_are_refused_by_name(scheme, tmp_path):
    with pytest.raises(tc.InputError, match=rf"{scheme.name} solves its equations on the CPU; use arch='cpu'"):
        simulate(scene(), scheme(dt=1e-5), arch="cuda", out=tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_process_without_a_device_stays_free_for_the_cpu(monkeypatch):
    """Taichi, which would start on the CPU then, is not started."""

    def none():
        raise runtime.NoDevice("none here")

    monkeypatch.setattr(runtime, "_started", None)
    monkeypatch.setattr(runtime, "count_devices", none)
    monkeypatch.setattr(runtime, "load", lambda: pytest.fail("Taichi was asked for"))
    with pytest.raises(tc.InputError, match="none here"):
        runtime.start("cuda")


def test_metals_need_room_for_the_state_of_their_points():
    elastic, metal = (plan_bytes(plan(scene(block(cells=4), one))) for one in (SOFT, METAL))
    assert metal - elastic > np.prod([64, 8, 8])  # cells, points, bytes; each keeps several numbers
