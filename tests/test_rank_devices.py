"""GPUs of several ranks: they take turns, memory counts for all that share a device, the rest is refused by name."""

import os
from types import SimpleNamespace

import cuda_contact_scenes
import pytest
from rank_scenes import SCENES

from tcontact.base.errors import InputError
from tcontact.device import cuda
from tcontact.planning.planning import plan
from tcontact.run import device_room, rank_devices

LAUNCHED = {"PMI_SIZE": "4", "PMI_RANK": "3"}


class Team:
    """One of two ranks, where the other one has the same; place: of the device of the other one, None: the same."""

    def __init__(self, place=None):
        self.comm, self.place = self, place

    def agree(self, error):
        """Raise the error."""
        if error is not None:
            raise error

    def allgather(self, own):
        """Return what both have."""
        return [own, own if self.place is None else (self.place, own[1])]


@pytest.mark.parametrize(
    ("environment", "installed", "visible"),
    [
        (LAUNCHED | {"MPI_LOCALRANKID": "1"}, 2, "1"),
        (LAUNCHED | {"MPI_LOCALRANKID": "3"}, 2, "1"),
        (LAUNCHED, 4, "3"),
        (LAUNCHED | {"OMPI_COMM_WORLD_LOCAL_RANK": "2", "CUDA_VISIBLE_DEVICES": "5,7"}, 8, "5"),
        (LAUNCHED | {"SLURM_LOCALID": "1", "CUDA_VISIBLE_DEVICES": "GPU-1b,GPU-2c"}, 8, "GPU-2c"),
        (LAUNCHED | {"CUDA_VISIBLE_DEVICES": "6"}, 8, "6"),
        (LAUNCHED, 1, None),
        (LAUNCHED, 0, None),
        ({}, 8, None),
    ],
)
def test_ranks_take_the_devices_of_a_machine_in_turn(monkeypatch, environment, installed, visible):
    """Those that the user lets the program see, else all that are there; one process takes the first, as always."""
    monkeypatch.setattr(os, "environ", dict(environment))  # which the choice changes
    monkeypatch.setattr(cuda, "_installed", lambda: installed)
    cuda.take_turn()
    assert os.environ.get(cuda.VISIBLE) == visible
    cuda.take_turn()  # of a second run in the process
    assert os.environ.get(cuda.VISIBLE) == visible


def started(monkeypatch, scene, room, place=None):
    """Start the ranks of a scene on devices with so many free bytes; return the backends that were started."""
    started, whole = [], plan(scene)
    monkeypatch.setattr(cuda, "find_device", lambda: cuda.Device("card", 1, 2 * room, room))
    monkeypatch.setattr(rank_devices.runtime, "start", lambda arch, threads: started.append(arch))
    parts = [SimpleNamespace(domain=domain) for domain in whole.domains]
    rank_devices.start_on_ranks(Team(place), scene, parts, "cuda", 1)
    return started


def test_memory_counts_for_all_ranks_that_share_a_device(monkeypatch):
    scene, _scheme = cuda_contact_scenes.full()
    needed = device_room.plan_bytes(plan(scene)) + device_room.RESERVE
    with pytest.raises(InputError, match=f"needs {2 * needed} bytes"):
        started(monkeypatch, scene, 2 * needed - 1)
    assert started(monkeypatch, scene, 2 * needed) == ["cuda"]
    assert started(monkeypatch, scene, needed, place=("another machine", None)) == ["cuda"]


def test_a_rank_without_a_device_refuses_the_run_on_all(monkeypatch):
    def none():
        raise cuda.NoDevice("no driver")

    scene, _scheme = cuda_contact_scenes.full()
    monkeypatch.setattr(cuda, "find_device", none)
    asked = []
    team = Team()
    team.allgather = lambda own: asked.append(own) or [own]
    with pytest.raises(InputError, match="no usable CUDA device"):
        rank_devices.start_on_ranks(team, scene, [SimpleNamespace(domain=plan(scene).domains[0])], "cuda", 1)
    assert len(asked) == 1  # the others wait for what it needs


def test_what_threads_do_not_step_is_refused_by_name(monkeypatch):
    with pytest.raises(InputError, match="with probes or maxima") as refusal:
        started(monkeypatch, SCENES["sensed"](), 2**40)
    assert refusal.value.field == "arch"


def test_devices_do_not_share_a_contact():
    assert rank_devices.sharing(None, "cuda") == rank_devices.sharing(1, "cuda") == 1
    assert rank_devices.sharing(None, "cpu") is None
    assert rank_devices.sharing(3, "cpu") == 3
    with pytest.raises(InputError, match="the first rank has the whole contact") as refusal:
        rank_devices.sharing(2, "cuda")
    assert refusal.value.field == "contact_ranks"


def test_a_run_goes_on_where_it_began():
    """The state of a device is another one than that of a CPU, and that of two devices another one than that of one."""
    device_room.check_same({"arch": "cuda"}, "cuda")
    device_room.check_same({}, "cpu")  # of an earlier version
    for kept, asked in (("cuda", "cpu"), ("cpu", "cuda")):
        with pytest.raises(InputError, match=f"computes on '{kept}'"):
            device_room.check_same({"arch": kept}, asked)
    rank_devices.check_as_many(2, 2, "cuda")
    rank_devices.check_as_many(2, 3, "cpu")
    with pytest.raises(InputError, match="as many"):
        rank_devices.check_as_many(2, 3, "cuda")
