"""`tcontact bench`: rows carry their errors, failures keep a row, yardsticks do the same work. No times are judged."""

import csv
import json

import numpy as np
import pytest
from conftest import THREADS

import tcontact as tc
from tcontact.commands.cli import main
from tcontact.lab.bench import accuracy, alternatives, blocks, chart, collect, parts, reference, small, table, timing
from tcontact.lab.bench import measure as measure_module
from tcontact.lab.bench.configuration import KINDS, LAWS, SHAPES, UNCOMPARED, Configuration, grid
from tcontact.lab.bench.measure import measure
from tcontact.mesh.elements import FORMULATIONS
from tcontact.planning.body_plan import SMALL
from tcontact.results.report import plain
from tcontact.scene import materials

TINY = Configuration("hex8", "linear", 2, THREADS, ("none", "normal", "full"), steps=4, seconds=0.01, batches=3)


@pytest.fixture(scope="module")
def rows():
    """The rows of a cube of two cells an edge that refuses full removal. By way of JSON, as from a process."""
    build = blocks.block

    def refusing(kind, law, size, contact="none", **options):
        if contact == "full":
            raise tc.InputError("removal", contact, "not with this cube")
        return build(kind, law, size, contact, **options)

    with pytest.MonkeyPatch.context() as patch:
        for element in SMALL:  # the tiny cube stands for a large one
            patch.setitem(SMALL, element, 0)
        patch.setattr(blocks, "block", refusing)
        return json.loads(json.dumps(plain(measure(TINY))))["rows"]


def report(rows):
    return {"machine": collect.machine(), "rows": rows}


def test_every_contact_gives_a_row_and_a_refused_one_keeps_its_reason(rows):
    assert [(row["contact"], row["ok"]) for row in rows] == [("none", True), ("normal", True), ("full", False)]
    assert rows[2]["reason"] == "InputError: removal = 'full': not with this cube"
    assert "rate" not in rows[2]
    assert {"kind", "law", "size", "threads", "arch", "cells"} <= set(rows[2])


def test_speeds_come_with_the_errors_of_the_same_run(rows):
    for row in rows[:2]:
        assert 0.0 < row["force_error"] <= 1e-13
        assert row["elastic_error"] <= 1e-13
        assert row["update_error"] <= 1e-13
        assert 0.0 < row["energy_error"] < 0.1
        for name in ("rate", "plain_rate", "kernel_rate", "copy_bytes_per_s", "ratio_to_plain", "roofline_share"):
            found = row[name]
            assert 0.0 < found["low"] <= found["first_quartile"] <= found["median"], name
            assert found["median"] <= found["third_quartile"] <= found["high"] < np.inf, name
            assert found["batches"] >= TINY.batches
        assert row["bytes_per_cell"] == sum(row["memory_bytes"].values()) / TINY.cells
    assert "ledger_share" in rows[0]
    assert "contact_share" not in rows[0]
    assert rows[1]["contact_share"]["high"] <= 1.0
    assert rows[1]["sweeps"] > 0.0  # a mean: a step whose residual is exactly 0 sweeps nothing
    assert 0.0 <= rows[1]["static_residual"] <= 1e-4


def test_yardsticks_do_the_same_work(rows):
    assert rows[0]["plain_error"] <= 1e-13
    assert rows[0]["plain_bytes_per_cell"] > 0.0
    # X, u, v, m, node_info and a force in and out at each of 27 nodes; 8 corners a cell
    assert rows[0]["step_bytes_per_cell"] == pytest.approx(32.0 + 27 / 8 * (24 + 48 + 48 + 8 + 4 + 48))


@pytest.mark.parametrize(
    ("kind", "law"),
    [(kind, law) for kind in ("hex8", "hex8-reduced", "tet4", "wedge6") for law in LAWS]
    + [("hex8-mean-dilatation", law) for law in LAWS if law != "st-venant-kirchhoff"],
)
def test_reference_force_is_the_slope_of_its_energy(kind, law):
    scene, u = blocks.shaken(kind, law, 2)
    further = {"mooney-rivlin": (0.2,), "ogden": (0.5, 1.3, 0.01, 5.0, 0.02, -2.0)}
    mesh, lame = scene.bodies[0].mesh, (0.7, 0.4, *further.get(law, ()))
    way = np.random.default_rng(1).uniform(-1.0, 1.0, u.shape)
    step = 1e-5 * np.abs(u).max()
    up, down = (reference.force(kind, law, lame, mesh.nodes, mesh.cells, u + s * way)[1] for s in (step, -step))
    force = reference.force(kind, law, lame, mesh.nodes, mesh.cells, u)[0]
    assert (up - down) / (2 * step) == pytest.approx(np.sum(force * way), rel=1e-6)


@pytest.mark.parametrize(
    ("kind", "law", "cells"),
    [
        ("hex8-reduced", "linear", 1),
        ("hex8-mean-dilatation", "linear", 1),
        ("wedge6", "linear", 2),
        ("tet4", "ogden", 6),
        pytest.param("hex8-mean-dilatation", "neo-hookean", 1, marks=pytest.mark.slow),
        pytest.param("wedge6", "ogden", 2, marks=pytest.mark.slow),
    ],
)
def test_every_element_is_measured_against_its_own_reference_and_plain_kernel(kind, law, cells):
    """Ours, the plain kernel and NumPy give the same forces; the plain kernel shares its cell with ours."""
    (row,) = measure(Configuration(kind, law, 3, THREADS, steps=4, seconds=0.01, batches=3))["rows"]
    assert row["ok"], row["reason"]
    assert row["cells"] == cells * 3**3
    assert 0.0 < row["force_error"] <= 1e-13
    assert row["elastic_error"] <= 1e-13
    assert row["plain_error"] <= 1e-13
    assert row["ratio_to_plain"]["median"] > 0.0


@pytest.mark.parametrize("kind", ["hex8-skew", "hex8-turned"])
def test_hexes_of_every_shape_are_checked_in_the_shape_that_is_timed(kind):
    """One matrix makes both meshes out of the same boxes, and the face of contact stays on its wall."""
    timed, checked = (scene.bodies[0].mesh.nodes for scene in (blocks.block(kind, "linear", 2, "normal"),
                                                               blocks.shaken(kind, "linear", 2)[0]))  # fmt: skip
    np.testing.assert_array_equal(timed, checked)
    assert np.abs(timed[:9, 2]).max() == 0.0
    assert 0.0 < accuracy.step_errors(kind, "linear", 2)["force_error"] <= 1e-13


@pytest.mark.parametrize(("kind", "law"), [("tet4", "mooney-rivlin"), ("hex8-reduced", "neo-hookean")])
def test_other_laws_are_measured_against_their_own_reference(kind, law):
    errors = accuracy.step_errors(kind, law, 2)
    assert 0.0 < errors["force_error"] <= 1e-13
    assert errors["elastic_error"] <= 1e-13


def test_what_has_no_reference_is_not_measured_against_another_one():
    with pytest.raises(tc.InputError, match="reference"):
        reference.shape_slopes("pyramid5")
    with pytest.raises(tc.InputError, match="reference"):
        reference.energy_and_stress("other", (1.0, 1.0), np.zeros((1, 3, 3)))


def test_every_element_and_law_is_known_to_the_bench():
    known = {*FORMULATIONS} - {*UNCOMPARED}
    assert known == {*KINDS} - {*SHAPES} == {*measure_module.WEIGHT}
    assert {*LAWS} == {*materials.LAWS}


def test_an_error_in_the_step_shows(monkeypatch):
    exact = reference.force

    def other(*arguments):
        force, energy = exact(*arguments)
        return force * (1.0 + 1e-7), energy * (1.0 - 1e-6)

    monkeypatch.setattr(reference, "force", other)
    errors = accuracy.step_errors("tet4", "neo-hookean", 2)
    assert errors["force_error"] == pytest.approx(1e-7, rel=1e-2)
    assert errors["elastic_error"] == pytest.approx(1e-6, rel=1e-2)


def test_compile_seconds_are_those_of_new_processes():
    found = collect.compile_seconds("tet4", "linear", "none", TINY)
    assert found["compile_cold_s"] > 0.0
    assert found["compile_warm_s"] is not None
    assert "compile_reason" not in found


def test_turn_by_turn():
    order = []
    works = {name: lambda name=name: order.append(name) or float(len(order)) for name in "abc"}
    taken = timing.rounds(works, 0.0, 3)
    assert "".join(order) == "abcbcacab"
    assert list(taken["a"]) == [1.0, 6.0, 8.0]
    assert timing.spread(taken["a"])["median"] == 6.0


def test_parts_exist_where_the_scene_has_them(rows):
    alone, touching = set(rows[0]["parts_s"]), set(rows[1]["parts_s"])
    assert {"force and update", "history row", "history", "guards", "loop"} <= alone
    assert not any("solve" in part or "contact" in part for part in alone)
    assert touching - alone >= {"contact cells", "boundary nodes and static solve"}
    assert alone | touching <= {*parts.OF_A_BODY, *parts.OF_THE_RUN, "loop"}


def test_the_step_of_a_small_body_is_one_part():
    """Its one launch was listed as the static solve."""
    found = parts.parts_of_a_step(blocks.block("hex8", "linear", 2, "normal", duration=1e-5))
    assert found[parts.WHOLE_STEP] > 0.0
    assert not {"force and update", "boundary nodes and static solve"} & found.keys()


def test_bar_of_a_hundred_cells_is_judged_by_its_exact_solution(monkeypatch):
    monkeypatch.setattr(small, "RUNS", 1)
    found = small.bar("cpu", THREADS)
    assert found["force_error"] <= 0.07
    assert found["energy_error"] <= 5e-3
    assert found["steps"] > 400


def test_a_process_that_dies_gives_rows_with_its_reason(rows, monkeypatch, tmp_path):
    configurations = grid(["hex8"], ["linear"], [2], [1, 2], contacts=TINY.contacts)
    dead = {"failed": "exit code -9: no message"}
    answers = iter([{"rows": [dict(row, threads=1) for row in rows]}, *[dead] * 7])
    monkeypatch.setattr(collect, "run_worker", lambda task, options, cache=None: next(answers))
    monkeypatch.setattr(collect, "compile_seconds", lambda *key: {"compile_cold_s": 2.0, "compile_warm_s": 0.5})
    said = []
    monkeypatch.setattr(collect, "TASKS", {})
    monkeypatch.setattr(collect, "start_seconds", lambda arch, threads: {"failed": "no start"})
    found = collect.collect(configurations, said.append)
    assert [row["ok"] for row in found["rows"]] == [True, True, False, False, False, False]
    assert {row["reason"] for row in found["rows"][3:]} == {"exit code -9: no message"}
    text = "\n".join(table.lines(found))
    assert text.count("FAILED hex8 linear 2^3") == 4
    assert "exit code -9" in text
    assert "2.0 / 0.5" in text
    table.write_csv(tmp_path / "bench.csv", found["rows"])
    with (tmp_path / "bench.csv").open(newline="", encoding="utf-8") as file:
        kept = list(csv.DictReader(file))
    assert len(kept) == 6
    assert float(kept[0]["rate.median"]) == rows[0]["rate"]["median"]
    assert kept[5]["reason"] == "exit code -9: no message"
    assert chart.draw(tmp_path / "bench.png", found)
    assert not chart.draw(tmp_path / "none.png", report(found["rows"][3:]))


@pytest.mark.parametrize("missing", ["force_error", "energy_error"])
def test_no_speed_is_printed_without_its_errors(rows, missing):
    table.lines(report(rows))
    with pytest.raises(KeyError):
        table.lines(report([{name: value for name, value in rows[0].items() if name != missing}]))


def test_a_real_process_answers_and_says_what_is_wrong(tmp_path, monkeypatch):
    """It finds the package from any folder, in a bare checkout too."""
    monkeypatch.chdir(tmp_path)
    assert collect.run_worker("bar", {"arch": "cpu", "threads": 0})["failed"].startswith("InputError: threads = 0")


def test_command_writes_numbers_table_and_chart(tmp_path, capsys):
    options = ["--quick", "--kinds", "tet4", "--contact", "none", "--steps", "4", "--seconds", "0.1", "--sizes", "2"]
    assert main(["bench", *options, "--out", str(tmp_path / "new")]) == 0
    found = json.loads((tmp_path / "new" / "bench.json").read_text(encoding="utf-8"))
    (row,) = found["rows"]
    assert row["ok"]
    assert row["cells"] == 6 * 2**3
    assert "compile_cold_s" not in row
    assert found["machine"]["versions"].keys() >= {"taichi", "numpy", "scipy", "felupe"}
    assert len(found["alternatives"][0]["rows"]) == 12
    assert (tmp_path / "new" / "bench.csv").exists()
    with (tmp_path / "new" / "alternatives.csv").open(newline="", encoding="utf-8") as file:
        assert {line["method"] for line in csv.DictReader(file)} == {*alternatives.METHODS}
    assert (tmp_path / "new" / "bench.png").read_bytes()[:4] == b"\x89PNG"
    printed = capsys.readouterr().out
    for word in ("Mcell/s", "err f", "err E", "x plain", "compile s", "GB/s", "x ours", "SciPy CSR"):
        assert word in printed


@pytest.mark.parametrize(
    "options", [["--kinds", "hex9"], ["--sizes", "0"], ["--seconds", "-1"], ["--contact", "some"], ["--threads", "x"]]
)
def test_bad_options_are_refused(options, capsys):
    assert main(["bench", *options]) == 2
    assert options[0] in capsys.readouterr().err


@pytest.mark.parametrize(
    "options",
    [
        ["--kinds", "tet4"],
        ["--laws", "linear"],
        ["--contact", "full"],
        ["--steps", "5"],
        ["--seconds", "1"],
        ["--arch", "cpu"],
        ["--threads", "1,2"],
        ["--sizes", "4,8"],
    ],
)
def test_the_comparison_of_solvers_refuses_options_that_it_would_ignore(options, tmp_path, capsys):
    assert main(["bench", "--solvers", *options, "--out", str(tmp_path / "new")]) == 2
    assert f"{options[0]} = " in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


def test_more_threads_than_a_process_can_have_are_refused(tmp_path, capsys):
    assert main(["bench", "--threads", "1,100000", "--out", str(tmp_path / "new")]) == 2
    assert "--threads = 100000: give at most 1024" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


def test_more_ranks_than_the_cores_can_take_are_refused(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("tcontact.commands.bench.cores", lambda: 2)
    monkeypatch.setattr("tcontact.lab.bench.rank_steps.compare", lambda *given: pytest.fail("it measures"))
    assert main(["bench", "--ranks", "2,17", "--out", str(tmp_path / "new")]) == 2
    assert "--ranks = 17: give at most 16" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("alone", ["--pairs", "--alternatives"])
@pytest.mark.parametrize("options", [["--kinds", "tet4"], ["--steps", "5"], ["--arch", "cpu"], ["--sizes", "4,8"]])
def test_a_part_measured_alone_refuses_options_that_it_would_ignore(alone, options, tmp_path, capsys):
    assert main(["bench", alone, *options, "--out", str(tmp_path / "new")]) == 2
    assert f"{options[0]} = " in capsys.readouterr().err
    assert main(["bench", alone, "--solvers", "--out", str(tmp_path / "new")]) == 2
    assert "give one of them" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


def test_a_gpu_refuses_several_threads(tmp_path, capsys):
    assert main(["bench", "--arch", "cuda", "--threads", "1,2", "--out", str(tmp_path / "new")]) == 2
    assert "--arch cuda takes one value" in capsys.readouterr().err


def test_a_quick_look_keeps_what_is_given(monkeypatch, tmp_path):
    """--quick changes defaults alone."""
    seen = []
    monkeypatch.setattr(collect, "collect", lambda found, say, quick: seen.extend(found) or {"machine": {}, "rows": []})
    monkeypatch.setattr(table, "lines", lambda report: [])
    monkeypatch.setattr(table, "write_csv", lambda path, rows: None)
    main(["bench", "--quick", "--laws", "linear,ogden", "--sizes", "3,4", "--seconds", "2", "--out", str(tmp_path)])
    assert {one.law for one in seen} == {"linear", "ogden"}
    assert {one.size for one in seen} == {3, 4}
    assert {(one.seconds, one.threads, one.batches) for one in seen} == {(2.0, 1, 3)}
    assert {one.contacts for one in seen} == {("none", "normal")}
