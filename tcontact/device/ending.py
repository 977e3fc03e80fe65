"""How ranks that work together end: what fails on one of them alone ends all, which would wait for it for ever.

From their roll call on (`team`) the ranks call collective methods. `ending_all` holds all of that, whatever a function
of the user does on one rank: raise an error, leave Python with `sys.exit()`, or be interrupted.
"""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager

from ..base.errors import InputError, OutputError
from .ranks import passed_on
from .team import Team

BEFORE = "before the first step"  # of a run


@contextmanager
def ending_all(team: Team | None, moment: str = "") -> Iterator[None]:
    """End all ranks, with the traceback of this one, on what leaves the block on this one alone; None: one process.

    moment: when that is, told of a rank that is interrupted; `Team.moment` has it from here on. `InputError` and
    `OutputError`, which all ranks have, and what `Team.agree` has raised on all of them pass.
    """
    if team is not None:
        team.moment = moment
    try:
        yield
    except (InputError, OutputError):
        raise
    except BaseException as error:
        if team is None or error is team.agreed:
            raise
        sys.stdout.flush()
        name = f"tcontact: rank {team.rank} of {team.size}"
        if isinstance(error, KeyboardInterrupt):
            when = f"interrupted {team.moment}".rstrip()
            print(f"{name} was {when}, which ends all ranks", file=sys.stderr)
        else:
            print(f"{name} failed, which ends all ranks:", file=sys.stderr)
            traceback.print_exc()
        passed_on(sys.stderr)
        team.comm.Abort(1)
        os._exit(1)  # where the launcher takes a moment
