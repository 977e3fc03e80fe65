"""Files of checkpoints: which of them stay, which are left behind, and what is said of a run that can go on."""

from frame_writer import write_run

from tcontact.commands.cli import main
from tcontact.results.files.vtkhdf import ResultFile
from tcontact.run.checkpoint import store


def test_the_last_complete_checkpoint_stays_where_a_later_one_is_not_complete(tmp_path):
    rows = []
    for row, spared in ((3, None), (6, (3, 2)), (9, (3, 2)), (12, (9, 2)), (15, (12, 2)), (9, (15, 2)), (18, (15, 2))):
        store.write(tmp_path, {"row": row, "ranks": 2}, {}, {}, spared)
        rows.append([stored.row for stored in store.read_all(tmp_path)[0]])
    assert rows == [[3], [6, 3], [9, 3], [12, 9], [15, 12], [15, 9], [18, 15]]


def test_what_goes_on_is_said_to_go_on_and_nothing_else(tmp_path, capsys):
    """A checkpoint that some rank has not written, or one whose frames are not in the file, is none."""
    write_run(tmp_path / "result.vtkhdf", 4)
    ResultFile.reopen(tmp_path / "result.vtkhdf", 4, {}).close()  # it names no end any more

    def said():
        assert main(["info", str(tmp_path)]) == 0
        return f"`tcontact resume {tmp_path}` goes on with it" in capsys.readouterr().out

    other = tmp_path / store.RANKS / "1"
    other.mkdir(parents=True)
    assert not said()
    for place, row, frames in ((tmp_path, 9, 4), (other, 6, 4), (tmp_path, 12, 5), (other, 12, 5)):
        store.write(place, {"ranks": 2, "row": row, "frames": frames}, {}, {})
        assert not said()
    store.write(tmp_path, {"ranks": 2, "row": 6, "frames": 4}, {}, {})
    assert said()


def test_a_run_that_goes_on_removes_what_it_leaves_behind(tmp_path):
    """What is as late as the checkpoint from which it goes on, or later; each rank in every second folder."""
    places = [tmp_path, tmp_path / store.RANKS / "1", tmp_path / store.RANKS / "2"]
    kept = [{(6, 3), (9, 2)}, {(9, 2)}, set()]
    for place, *every in zip(places, kept, ({}, {(9, 3)}, {(9, 3), (12, 3)}), strict=True):
        place.mkdir(parents=True, exist_ok=True)
        for row, ranks in sorted(set().union(*every)):
            store.write(place, {"ranks": ranks, "row": row}, {}, {})
    for rank in range(2):
        store.remove_later(tmp_path, (9, 2), rank, 2)
    assert [{one.place for one in store.read_all(place)[0]} for place in places] == kept
