"""Several processes under mpiexec: forces of shared nodes add up with equal bits, and what cannot run says so once."""

import importlib.util
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import tcontact as tc
from tcontact.base.errors import InputError
from tcontact.device import ranks
from tcontact.device.ending import ending_all
from tcontact.device.team import Team
from tcontact.lab.bench.rank_steps import model
from tcontact.planning.partition.cell_graph import CellGraph
from tcontact.planning.partition.cut import cut_beside
from tcontact.run.rank_checks import check_ranks
from tcontact.run.rank_files import on_all
from tcontact.schemes.explicit.rank_state import of_all_ranks

METAL = tc.ElastoPlastic(2e7, 0.3, 1000.0, hardening=tc.LinearHardening(5e4, 1e6))
HERE = Path(__file__).resolve().parent
MPIEXEC = shutil.which("mpiexec") or shutil.which("mpiexec", path=str(Path(sys.executable).parent))
MISSING = [name for name in ("mpi4py", "pymetis") if importlib.util.find_spec(name) is None]
pytestmark = [
    pytest.mark.ranks,
    pytest.mark.skipif(MPIEXEC is None, reason="there is no mpiexec: pip install mpich"),
    pytest.mark.skipif(bool(MISSING), reason=f"not installed: {', '.join(MISSING)}; pip install 'tcontact[mpi]'"),
]


def mpiexec(count, *arguments, timeout=900):
    """Run Python with these arguments in several processes."""
    environment = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(HERE.parent)}
    command = [MPIEXEC, "-n", str(count), sys.executable, *map(str, arguments)]
    return subprocess.run(
        command, cwd=HERE, env=environment, capture_output=True, text=True, timeout=timeout, check=False
    )


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
@pytest.mark.parametrize("count", [2, 3, 4])
def test_forces_of_shared_nodes_add_up_with_equal_bits_in_all_copies(count, kind):
    done = mpiexec(count, "rank_worker.py", kind)
    assert done.returncode == 0, done.stderr
    found = dict(line.split() for line in done.stdout.splitlines())
    assert float(found["error"]) < 1e-15
    assert found["copies"] == "1"
    assert found["bytes"] == "0"


@pytest.mark.parametrize("steps", [1, 500])
def test_a_killed_rank_ends_all(steps):
    """The others wait for it in an exchange; `mpiexec` raises `TimeoutExpired` if they go on."""
    done = mpiexec(3, "rank_killed.py", steps)
    assert done.returncode != 0


def test_all_ranks_end_a_block_of_steps_by_what_all_of_them_have():
    """Their energies add up; the smallest det F, the largest rates and counts, and any trouble count."""
    one, other = (3.0, 0.4, 1.0, 5.0, 0.0, 0.0), (2.0, 0.9, 7.0, 0.0, 2.0, 1.0)
    assert of_all_ranks(np.array([one, other])) == (5.0, 0.4, 7.0, 5.0, 2.0, 1.0)


@pytest.mark.parametrize(
    ("field", "scene", "options"),
    [
        ("scheme", {}, {"scheme": tc.DiscreteGradient(dt=1e-5)}),
        ("Scene.bodies[0].formulation", {"formulation": "node-averaged"}, {"arch": "cuda"}),
        ("Scene.bodies[0].formulation", {"material": METAL}, {"arch": "cuda"}),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_several_ranks_do_not_run_is_refused_by_name(field, scene, options):
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2), kind="tet4")
    own = tc.Body(mesh, **({"material": tc.NeoHookean(2e7, 0.3, 1000.0)} | scene))
    known = {"scheme": tc.CentralDifference(), "arch": "cpu"} | options
    with pytest.raises(InputError, match=r"one rank in this version|run on CPUs") as refusal:
        check_ranks(tc.Scene([own], duration=1e-3), **known, ranks=2)
    assert refusal.value.field == field


def test_tetrahedra_that_would_average_at_nodes_run_on_several_gpus_as_their_refusal_says():
    """Where averages are the default, to leave the formulation out does not help."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2), kind="tet4")
    known = {"scheme": tc.CentralDifference(), "arch": "cuda", "ranks": 2}
    with pytest.raises(InputError, match="give formulation='full'") as refusal:
        check_ranks(tc.Scene([tc.Body(mesh, METAL)], duration=1e-3), **known)
    assert "leave it out" not in str(refusal.value)
    check_ranks(tc.Scene([tc.Body(mesh, METAL)], duration=1e-3), **known | {"arch": "cpu"})
    check_ranks(tc.Scene([tc.Body(mesh, METAL, formulation="full")], duration=1e-3), **known)


def test_a_warning_that_one_rank_makes_an_error_is_raised_on_all():
    """`ending_all` lets pass what is raised on all ranks."""

    class Comm(SimpleNamespace):
        allgather = staticmethod(lambda value: [None, value])

    team = Team(Comm(Get_rank=lambda: 1, Get_size=lambda: 2))

    def warn():
        raise UserWarning("an error here")

    with pytest.raises(UserWarning, match="an error here") as found, ending_all(team):
        on_all(team, warn)
    assert team.agreed is found.value


def test_an_error_of_all_ranks_is_told_once_and_nothing_is_written(tmp_path):
    out = tmp_path / "run"
    done = mpiexec(3, "-m", "tcontact", "run", "cube-impact", "--set", "cells=x", "--out", out)
    assert done.returncode == 2
    assert done.stderr.count("tcontact: ") == 1
    assert not out.exists()
    again = mpiexec(2, "-m", "tcontact", "resume", out)
    assert again.returncode == 2
    assert again.stderr.count("no such folder") == 1


def test_a_case_runs_on_two_ranks_with_its_pictures_and_a_folder_is_not_overwritten(tmp_path):
    out = tmp_path / "run"
    words = ["-m", "tcontact", "run", "cube-impact", "--set", "cells=6", "--frames", "2", "--out", out]
    done = mpiexec(2, *words)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("finished at") == 1
    assert "2 ranks" in done.stdout
    assert {"summary.json", "history.csv", "result.vtkhdf", "energy.png"} <= {path.name for path in out.iterdir()}
    assert json.loads((out / "summary.json").read_text(encoding="utf-8"))["ranks"] == 2
    again = mpiexec(2, *words)
    assert again.returncode == 2
    assert again.stderr.count("holds another run") == 1


def test_an_error_in_a_script_is_told_once():
    """All ranks raise it; the traceback is that of the first one."""
    done = mpiexec(3, "rank_refused.py")
    assert done.returncode != 0
    assert done.stderr.count("Traceback") == 1
    assert "scheme = " in done.stderr
    assert "one rank in this version" in done.stderr


def test_a_user_without_a_home_shares_a_contact_and_sees_what_the_script_prints(monkeypatch):
    """The compiler aborts without a home; the first rank needs its laws before it computes, to plan for all."""
    monkeypatch.delenv("HOME", raising=False)
    done = mpiexec(2, "rank_bare_contact.py")
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, "finished", "")


def test_too_many_ranks_for_the_free_cells_are_refused():
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
    with pytest.raises(InputError, match="stay on the first rank; run it without mpiexec, or refine the mesh"):
        cut_beside(lambda: CellGraph.of(mesh.blocks, mesh.node_count), 8, 2, np.arange(8))


def test_without_a_launcher_there_is_one_rank_and_no_mpi(monkeypatch):
    for names in ranks.VARIABLES:
        for name in names:
            monkeypatch.delenv(name, raising=False)
    assert ranks.launched() == (1, 0)
    assert ranks.communicator() is None
    script = "import sys, tcontact.commands.cli, tcontact.device.exchange; sys.exit('mpi4py' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], cwd=HERE.parent, check=False).returncode == 0


def test_a_process_that_a_rank_starts_is_no_rank(monkeypatch):
    monkeypatch.setenv("PMI_SIZE", "4")
    monkeypatch.setenv("PMI_RANK", "2")
    assert ranks.launched() == (4, 2)
    monkeypatch.setenv(ranks.OWNER, str(os.getpid()))
    assert ranks.launched() == (4, 2)
    script = "from tcontact.device import ranks; print(ranks.launched())"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=HERE.parent, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.stdout.split() == ["(1,", "0)"]


def test_one_rank_of_a_launcher_is_a_run_without_mpi(monkeypatch):
    monkeypatch.setenv("PMI_SIZE", "1")
    monkeypatch.setenv("PMI_RANK", "0")
    assert ranks.communicator() is None


@pytest.mark.parametrize("names", ranks.VARIABLES[1:])
def test_a_launcher_of_another_mpi_is_named(names):
    """mpi4py sees one process where the launcher has started four, which would all write one folder."""
    script = "from tcontact.device import ranks; ranks.communicator()"
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PMI", "OMPI", "SLURM"))}
    environment |= dict(zip(names, ("4", "0"), strict=True))
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, cwd=HERE.parent, env=environment, capture_output=True, text=True, check=False)
    assert "its MPI is not that of the launcher" in done.stderr
    assert f"unset {names[0]}" in done.stderr


def test_a_missing_mpi4py_is_named(monkeypatch):
    monkeypatch.setenv("PMI_SIZE", "2")
    monkeypatch.setenv("PMI_RANK", "1")
    monkeypatch.setitem(sys.modules, "mpi4py", None)
    with pytest.raises(InputError, match=r"tcontact\[mpi\]"):
        ranks.communicator()


def test_the_bench_measures_two_ranks_beside_one(tmp_path):
    words = ["-m", "tcontact", "bench", "--ranks", "1,2", "--sizes", "4", "--contact", "none", "--out", str(tmp_path)]
    done = subprocess.run([sys.executable, *words], cwd=HERE.parent, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    rows = json.loads((tmp_path / "ranks.json").read_text(encoding="utf-8"))["rows"]
    assert [row["ranks"] for row in rows] == [1, 2]
    assert rows[0]["messages"] == 0.0
    assert rows[1]["messages"] >= 1.0
    assert rows[1]["bytes"] >= 24.0 * 25.0  # a plane of nodes between the halves
    assert rows[0]["energy_error"] == pytest.approx(rows[1]["energy_error"], rel=1e-6)
    assert "a model, not measured" in done.stdout


def test_the_model_of_scaling_knows_its_limits():
    row = {"contact": "normal", "size": 24, "ms": 2.0, "cells": 24**3}
    ones = model(row)
    assert all(0.0 < one["efficiency"] <= 1.0 for one in ones)
    assert all(one["efficiency"] == 1.0 for one in ones if one["ranks"] == 1)
    crowds = {one["cells"]: one["efficiency"] for one in ones if one["ranks"] == 512}
    alone = {cells: (cells + 4 * cells ** (2 / 3)) / (5 * cells ** (2 / 3)) / 512 for cells in crowds}
    assert crowds[64**3] <= alone[64**3]  # the first rank has all contact cells
    assert alone[256**3] < crowds[256**3] < 0.8  # ranks share them, and wait for each other after every colour


def test_the_doctor_looks_at_every_rank():
    """Each of the ranks is named once; the self test runs on both together, and one of them tells."""
    done = mpiexec(2, "-m", "tcontact", "doctor")
    assert done.returncode == 0, done.stdout + done.stderr
    for rank in (0, 1):
        assert done.stdout.count(f"rank {rank} on ") == 1
    assert done.stdout.count("us for 1000 shared nodes to every neighbour") == 1
    assert done.stdout.count("self test") == 1


@pytest.mark.parametrize("option", ["--compile", "--engines"])
def test_the_doctor_refuses_on_ranks_what_takes_one(option):
    done = mpiexec(2, "-m", "tcontact", "doctor", option)
    assert done.returncode != 0
    assert (done.stdout + done.stderr).count(option) == 1


def test_a_communicator_of_the_script_says_who_shares_a_scene(tmp_path):
    """Two of three processes share one, the third runs it alone; then each has its own, then all share one."""
    done = mpiexec(3, "rank_comm.py", tmp_path)
    assert done.returncode == 0, done.stderr
    found = dict(line.split(" ", 1) for line in done.stdout.splitlines())
    assert 0.0 < float(found["errors"]) < 1e-11
    assert [float(speed) for speed in found["speeds"].split()] == pytest.approx([1.0, 2.0, 3.0])
    assert found["ranks"] == "2 1 1"
    assert set(found["threads"].split()) == {str(max(1, len(os.sched_getaffinity(0)) // 3))}
    assert found["still"] == found["speeds"]
    assert found["parted"].startswith("comm = None: these ranks have not shared one run")
    assert found["refused"].startswith("comm = 'world': give a communicator of mpi4py")


def test_a_communicator_of_one_process_needs_no_launcher():
    """It is the run of a single process, with its bits; MPI starts in a process of its own."""
    script = """
import tcontact as tc
from mpi4py import MPI
from rank_scenes import block

scene = tc.Scene([block(counts=(2, 2, 2))], duration=2e-4)
own, usual = tc.simulate(scene, comm=MPI.COMM_SELF), tc.simulate(scene)
print(own.position.tobytes() == usual.position.tobytes())
for wrong in (MPI.COMM_NULL, 2):
    try:
        tc.simulate(scene, comm=wrong)
    except tc.InputError as error:
        print(error.field)
"""
    command = [sys.executable, "-c", script]
    environment = os.environ | {"PYTHONPATH": f"{HERE}{os.pathsep}{HERE.parent}"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["True", "comm", "comm"], done.stderr


def test_the_cores_of_a_machine_are_shared_by_the_ranks_on_it(monkeypatch):
    for name in ("PMI_SIZE", "PMI_RANK", *ranks.BESIDE):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 12)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _pid: set(range(12)))
    assert ranks.cores_of_a_rank() == 12
    monkeypatch.setenv("SLURM_STEP_NUM_TASKS", "24")
    monkeypatch.setenv("SLURM_PROCID", "3")
    assert ranks.cores_of_a_rank() == 1  # as far as is known all 24 are here
    monkeypatch.setenv(ranks.SLURM_BESIDE, "4(x5),3,1")
    assert ranks.cores_of_a_rank() == 3
    monkeypatch.setenv(ranks.BESIDE[0], "2")
    assert ranks.cores_of_a_rank() == 6
    monkeypatch.setattr(os, "sched_getaffinity", lambda _pid: {5})  # bound to a core
    assert ranks.cores_of_a_rank() == 1
