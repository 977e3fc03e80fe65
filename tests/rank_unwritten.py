"""A rank whose disk is full at its second frame: `mpiexec -n P python rank_unwritten.py FOLDER RANK part|full|file`.

full: no rank can close its file either, as what it has not yet written finds no room."""

import errno
import sys
import warnings
from pathlib import Path

from rank_scenes import SCENES

import tcontact as tc
from tcontact.device import ranks
from tcontact.errors import OutputError
from tcontact.results.files.master_file import MasterFile
from tcontact.results.files.part_file import PartFile


def main(folder, rank, which):
    """Fail in the second frame on one rank; every rank writes what it is told beside the folder, in FOLDER.RANK."""
    kind, name = (MasterFile, "add") if which == "file" else (PartFile, "append")
    original = getattr(kind, name)

    def write(self, *given):
        if len(self) == 1 and ranks.launched()[1] == int(rank):
            raise OSError(errno.ENOSPC, "No space left on device")
        return original(self, *given)

    def close(self):
        closed(self)
        raise OSError(errno.ENOSPC, "No space left on device")

    setattr(kind, name, write)
    if which == "full":
        closed, PartFile.close = PartFile.close, close
    warnings.simplefilter("ignore")
    try:
        tc.simulate(SCENES["normal"](), out=folder, frames=4, threads=1)
    except OutputError as error:
        # a file for each: what several processes print can come out on one line
        Path(f"{folder}.{ranks.launched()[1]}").write_text(f"{error.result.reason}: {error}", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
