"""Programs that use Taichi themselves: where a run cannot go beside them one line says so, and nothing is destroyed."""

from scenes import python

APART = "keep tcontact apart from what calls ti.init or ti.reset"
HEAD = """
import os
os.environ["TI_OFFLINE_CACHE_FILE_PATH"] = sys.argv[1]
import taichi as ti
from tcontact.base.errors import InputError
import tiny_kernel

def told():
    try:
        return tiny_kernel.run().sum()
    except InputError as error:
        return error
"""


def lines(code, tmp_path):
    done = python(HEAD + code, tmp_path)
    assert done.returncode == 0, done.stderr[-2000:]
    return [line for line in done.stdout.splitlines() if not line.startswith("[Taichi]")]


def test_data_that_a_program_has_in_taichi_stays(tmp_path):
    """The start of a run took the memory of its fields, and reading them ended the process."""
    code = """
ti.init(arch=ti.cpu, log_level=ti.ERROR)
x = ti.ndarray(ti.f32, 4)
print(told())
print(x[2])
x = ti.field(ti.f32, 4)
print(told())
x[2] = 3.0
del x
print(told())
ti.reset()
print(told())
"""
    unread, read, field, used, free = lines(code, tmp_path)
    for refused in (unread, field, used):
        assert "in use in it by this program" in refused
        assert APART in refused
    assert (read, free) == ("0.0", "6.0")


def test_taichi_started_anew_after_a_run_is_refused(tmp_path):
    """The kernels of a second run were taken for those of a program that was gone: the process crashed."""
    code = """
ti.init(arch=ti.cpu, log_level=ti.ERROR)  # nothing is made with it
print(told(), told())
x = ti.field(ti.f64, 4)
x[1] = 5.0
print(told(), x[1])
ti.init(arch=ti.cpu, log_level=ti.ERROR)
print(told())
x = ti.field(ti.f64, 4)
x[1] = 7.0
from tcontact.device import runtime
runtime.keep_kernels()
print(x[1])
ti.reset()
print(told())
"""
    first, beside, anew, kept, reset = lines(code, tmp_path)
    assert (first, beside, kept) == ("6.0 6.0", "6.0 5.0", "7.0")
    for refused in (anew, reset):
        assert "started anew in it after tcontact" in refused
        assert APART in refused
