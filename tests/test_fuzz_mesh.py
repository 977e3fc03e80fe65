"""Damaged mesh and surface files: each is read as a valid mesh or refused with `InputError`, nothing else.

The reading runs in a process of its own with a bound on its memory: a crash or a giant allocation ends that process.
"""

import json
import sys

import numpy as np
import pytest
from mesh_files import NAMES, WRITERS, box, gmsh_content, second_order
from scenes import python
from surfaces import box as box_surface

FAST, SLOW = 120, 2000
MEMORY = 3 * 2**30  # of address space on top of what importing takes
SECONDS = 20  # of processor time for one file: a hang, not a slow machine

ABAQUS = """*Heading
*Node, nset=all
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
*Element, type=C3D8, elset=solid
1, 1, 2, 3, 4, 5, 6, 7, 8
*Nset, nset=low, generate
1, 4, 1
*Elset, elset=one
1
*Surface, type=ELEMENT, name=top
one, S2
"""
ASSEMBLY = f"""*Part, name=Block
{ABAQUS.split("*Heading")[1].strip()}
*End Part
*Assembly, name=a
*Instance, name=Left, part=Block
*End Instance
*Instance, name=Right, part=Block
3., 0., 0.
0., 0., 0., 0., 0., 1., 30.
*End Instance
*Nset, nset=both, instance=Left, generate
1, 3, 2
*Nset, nset=both, instance=Right
low, 7
*Elset, elset=_s, instance=Right
1
*Surface, name=side
_s, S3
Left.one, S4
*End Assembly
"""


def originals(folder):
    """Valid files of every format."""
    import meshio

    for kind in ("hex8", "tet4"):
        points, blocks = gmsh_content(kind)
        for version, write in WRITERS.items():
            for binary in (False, True):
                write(
                    folder / f"{kind}-{version}-{binary}.msh", points, range(1, len(points) + 1), blocks, NAMES, binary
                )
        mesh, word = box(kind), {"hex8": "hexahedron", "tet4": "tetra"}[kind]
        part = meshio.Mesh(mesh.nodes, [(word, mesh.cells)])
        part.write(folder / f"{kind}.vtu")
        part.write(folder / f"{kind}-text.vtu", binary=False)
    more, higher = second_order(points, blocks)
    WRITERS["4.1"](folder / "tet10.msh", more, range(1, len(more) + 1), higher, NAMES, True)
    (folder / "one.inp").write_text(ABAQUS)
    (folder / "two.inp").write_text(ASSEMBLY)
    points, triangles = box_surface()
    skin = meshio.Mesh(points, [("triangle", triangles)])
    for name, options in (("a.stl", {"binary": True}), ("b.stl", {"binary": False}), ("c.obj", {}), ("d.ply", {})):
        skin.write(folder / name, **options)
    skin.write(folder / "e.ply", binary=False)
    return sorted(folder.iterdir())


def damaged(data, generator):
    """The bytes with one to three faults."""
    data = bytearray(data)
    for _ in range(generator.integers(1, 4)):
        size = len(data)
        at, end = sorted(generator.integers(0, size + 1, 2).tolist())
        end = min(end, at + int(generator.integers(1, 200)))
        kind = generator.integers(0, 7)
        if kind == 0:  # bits
            for place in generator.integers(0, max(size, 1), 3) if size else ():
                data[place] ^= 1 << int(generator.integers(0, 8))
        elif kind == 1:  # cut short
            data = data[:at]
        elif kind == 2:  # a piece twice
            data[end:end] = data[at:end]
        elif kind == 3:  # a piece lost
            del data[at:end]
        elif kind == 4:  # a piece elsewhere
            data[int(generator.integers(0, size + 1)) :][:0] = b""
            place = int(generator.integers(0, size + 1))
            data[place:place] = data[at:end]
        elif kind == 5:  # a number that counts something
            digits = [i for i in range(size) if 48 <= data[i] <= 57]
            if digits:
                place = digits[int(generator.integers(0, len(digits)))]
                words = (b"-1", b"99999999999", b"4294967295", b"nan", b"1e400", b"0", b"")
                data[place : place + 1] = words[int(generator.integers(0, len(words)))]
        else:  # four bytes of a binary count
            words = (b"\xff\xff\xff\x7f", b"\xff\xff\xff\xff", b"\0\0\0\0", b"\0\0\0\x80")
            data[at : at + 4] = words[int(generator.integers(0, len(words)))]
    return bytes(data)


READ = """
import json, resource, signal, sys, traceback, warnings
from pathlib import Path
import numpy as np
import meshio, scipy.spatial, scipy.sparse.csgraph
import tcontact as tc
warnings.simplefilter("ignore")
memory, seconds = int(sys.argv[1]), int(sys.argv[2])
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + memory, used + memory))
class Hung(BaseException):
    pass
def alarm(*_):
    raise Hung
signal.signal(signal.SIGPROF, alarm)
for line in sys.stdin:
    name = line.strip()
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        if name.endswith((".stl", ".obj", ".ply")):
            found = tc.Sdf.from_surface(name, cells=6)
            assert np.isfinite(found.grid).all()
        else:
            found = tc.read_mesh(name)
            tc.Mesh(found.nodes, found.cells, found.kind, found.node_sets, found.face_sets)
        said = "valid"
    except tc.InputError as error:
        said = "InputError"
        if not (error.field and error.remedy) or "MemoryError" in str(error):
            said = f"bad InputError {error}"
    except BaseException:
        said = traceback.format_exc()[-1500:]
    signal.setitimer(signal.ITIMER_PROF, 0)
    print(json.dumps([name, said]), flush=True)
"""


def outcomes(folder, count, seed):
    """What became of `count` damaged files."""
    valid, spoiled = folder / "valid", folder / "spoiled"
    valid.mkdir(), spoiled.mkdir()
    files = originals(valid)
    generator = np.random.default_rng(seed)
    names = [str(path) for path in files]
    for number in range(count):
        source = files[number % len(files)]
        path = spoiled / f"{number:05d}{source.suffix}"
        path.write_bytes(damaged(source.read_bytes(), generator))
        names.append(str(path))
    done = python(READ, MEMORY, SECONDS, input="\n".join(names))
    said = dict(json.loads(line) for line in done.stdout.splitlines())
    assert done.returncode == 0, (len(said), done.stderr[-2000:])
    assert [said[str(path)] for path in files] == ["valid"] * len(files)
    assert len(said) == len(names)
    return said


def check(folder, count, seed):
    said = outcomes(folder, count, seed)
    wrong = {name: what for name, what in said.items() if what not in ("valid", "InputError")}
    assert not wrong, (len(wrong), list(wrong.items())[:3])
    refused = sum(what == "InputError" for what in said.values())
    assert refused > count / 3, "the damage is too small to test anything"


@pytest.mark.skipif(sys.platform != "linux", reason="bounds the memory as Linux does")
def test_damaged_files_are_refused_or_read(tmp_path):
    check(tmp_path, FAST, 1)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="bounds the memory as Linux does")
def test_two_thousand_damaged_files_are_refused_or_read(tmp_path):
    check(tmp_path, SLOW, 2)
