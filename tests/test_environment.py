"""Users without a home, folders that take no files, limits on files and memory: it works, or one line says why not."""

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from scenes import ROOT, python

from tcontact.base.errors import InputError
from tcontact.device import kernel_list, runtime

LIMIT = "TI_OFFLINE_CACHE_MAX_SIZE_OF_FILES"
OWN = ("HOME", "XDG_CACHE_HOME", "TI_OFFLINE_CACHE_FILE_PATH", LIMIT)


def go(arguments, environment=None, **limits):
    """A process with these variables in place of its OWN; limits: of `resource`, by name."""
    inherited = {name: value for name, value in os.environ.items() if name not in OWN}

    def limit():
        for name, size in limits.items():
            resource.setrlimit(getattr(resource, name), (size, size))

    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=300,
        cwd=ROOT,
        env=inherited | (environment or {}),
        preexec_fn=limit,
    )


@pytest.mark.parametrize(
    ("variable", "value"),
    [
        (None, None),
        ("HOME", "/proc"),
        ("HOME", "FILE"),
        ("XDG_CACHE_HOME", "FILE"),
        ("TI_OFFLINE_CACHE_FILE_PATH", "FILE/below"),
    ],
)
def test_kernels_are_not_kept_where_no_file_can_be(variable, value, tmp_path):
    (tmp_path / "file").touch()
    wanted = {} if variable is None else {variable: value.replace("FILE", str(tmp_path / "file"))}
    done = go([ROOT / "tests" / "tiny_kernel.py", ROOT], wanted)
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, "6.0", "")


def test_kernels_are_kept_only_where_there_is_room_for_whole_ones(tmp_path):
    for name, limits, kept in (("limited", {"RLIMIT_FSIZE": 2**16}, 0), ("free", {}, 1)):
        folder = tmp_path / name
        done = go([ROOT / "tests" / "tiny_kernel.py", ROOT], {"TI_OFFLINE_CACHE_FILE_PATH": str(folder)}, **limits)
        assert done.returncode == 0, done.stderr
        assert (len(list(folder.glob("*.tic"))) > 0) == kept


@pytest.mark.parametrize(("wanted", "bytes_kept"), [({}, 2**30), ({LIMIT: "12345"}, 12345)])
def test_the_kernels_of_all_cases_have_room(wanted, bytes_kept, tmp_path):
    """Taichi has room for 100 MB; a process that ends above that removes a quarter, the first cases of `doctor`."""
    code = "from tcontact.device import runtime; print(runtime.start('cpu', 1).cfg.offline_cache_max_size_of_files)"
    done = go(["-c", code], {"XDG_CACHE_HOME": str(tmp_path)} | wanted)
    assert (done.returncode, done.stdout.strip()) == (0, str(bytes_kept)), done.stderr


@pytest.mark.parametrize(
    "damage", [Path.unlink, lambda file: file.write_bytes(b""), lambda file: file.write_bytes(b"x")]
)
def test_a_kernel_whose_file_is_lost_is_stored_again(damage, tmp_path):
    """Taichi compiles it in every run and never stores it, since it stands in its list; the others are left alone."""
    program = "import sys; sys.path[:0] = ['.', 'tests']; import tiny_kernel; tiny_kernel.run({})"
    files = []
    for option in ("", "3.0", ""):
        if option == "" and files:
            damage(files[0])
        done = go(["-c", program.format(option)], {"TI_OFFLINE_CACHE_FILE_PATH": str(tmp_path)})
        assert done.returncode == 0, done.stderr
        files += sorted(set(tmp_path.glob("*.tic")) - set(files))
    assert len(files) == 2
    for file in files:
        assert file.stat().st_size > 1000
    assert kernel_list.HEAD.unpack_from((tmp_path / kernel_list.LIST).read_bytes())[-2:] == (
        sum(file.stat().st_size for file in files),
        2,
    )


def test_a_list_of_another_form_is_left_as_it_is(tmp_path):
    for content in (b"", b"\x07", bytes(30), b"\xc8" + bytes(199)):
        (tmp_path / kernel_list.LIST).write_bytes(content)
        kernel_list.strike_lost(tmp_path)
        assert (tmp_path / kernel_list.LIST).read_bytes() == content
    kernel_list.strike_lost(tmp_path / "absent")


def test_no_more_threads_are_started_than_a_system_can_have():
    """A hundred thousand took every process of the machine, and ended in no message."""
    with pytest.raises(InputError, match="from 1 to 1024"):
        runtime.start("cpu", 100_000)


def test_a_command_keeps_the_kernels_that_it_has_compiled(tmp_path):
    """Taichi stores them where its program is taken apart, which a command does not wait for."""
    code = "import sys; sys.path.insert(0, 'tests'); import tcontact.commands.cli as cli, tiny_kernel; "
    run = "tiny_kernel.run(); cli.main(['--version'])"
    done = go(["-c", code + run], {"TI_OFFLINE_CACHE_FILE_PATH": str(tmp_path)})
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    assert list(tmp_path.glob("*.tic"))


def test_too_little_memory_for_taichi_is_one_line(tmp_path):
    run = ["-m", "tcontact", "run", "bar-impact", "--out", tmp_path / "out"]
    done = go(run, {"OPENBLAS_NUM_THREADS": "1"}, RLIMIT_AS=10**9)
    assert done.returncode == 1
    assert "not enough memory" in done.stderr
    assert "ulimit -v" in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_a_working_directory_that_was_removed_is_named(tmp_path):
    code = """
import os, tcontact as tc
from pathlib import Path
from tcontact.run.folder_lock import make_folder
place = Path(sys.argv[1], "place")
place.mkdir()
os.chdir(place)
place.rmdir()
body = tc.Body(tc.box_mesh((1, 1, 1), (1, 1, 1)), tc.NeoHookean(1e6, 0.3, 1e3))
for out in (None, "relative", Path(sys.argv[1], "out")):
    try:
        tc.simulate(tc.Scene([body], duration=1e-3), out=out)
    except tc.InputError as error:
        print(error)
try:
    make_folder(Path("relative"))
except tc.InputError as error:
    print(error)
"""
    done = python(code, tmp_path)
    assert done.returncode == 0, done.stderr
    told = done.stdout.splitlines()
    assert len(told) == 4
    for line in told:
        assert line.startswith("working directory = '.': was removed; change to a folder that exists")


def test_a_result_file_over_the_size_limit_ends_with_its_message(tmp_path):
    """What HDF5 had open must be closed: at the end of the process it crashed on it."""
    code = """
import resource, numpy as np, tcontact as tc
from tcontact.results.files.vtkhdf import ResultFile
mesh = tc.box_mesh((1, 1, 1), (8, 8, 8))
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
try:
    ResultFile.create(sys.argv[1], mesh.nodes, [("hex8", mesh.cells)])
except OSError as error:
    print(error.strerror)
"""
    done = python(code, tmp_path / "result.vtkhdf")
    assert (done.returncode, done.stdout) == (0, "File too large\n")


def test_doctor_fills_the_kernel_cache(tmp_path):
    """A process that ends leaves the kernels of the named cases; the next one finds them and adds none."""
    program = "from tcontact.commands.doctor import compile_cases; compile_cases(['bar-impact', 'friction-layer'])"
    kept = []
    for _ in range(2):
        done = go(["-c", program], {"HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path)})
        assert done.returncode == 0, done.stderr
        assert done.stdout.split()[0] == "bar-impact"
        assert "friction-layer" not in done.stdout  # it is no scene
        kept.append(sorted(file.name for file in tmp_path.rglob("*.tic")))
    assert kept[0] == kept[1]
    assert len(kept[0]) > 1
