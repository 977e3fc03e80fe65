"""The command line: `tcontact COMMAND ...`.

Exit code 0: all well; 1: a run or one of its checks failed; 2: bad usage (the message says what to do instead).
"""

from __future__ import annotations

import argparse
import atexit
import gc
import logging
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module

from ..base import stages
from ..base.errors import InputError, OutputError
from ..base.version import __version__
from ..device import ranks, runtime
from ..device.last_words import told
from ..run.interrupts import Terminated, terminations
from .streams import safe_output
from .ticker import ticking
from .words import joined

TICKING = ("run", "resume", "render", "report")  # commands that tell what they are doing
ALONE = ("list", "info", "render", "report", "export")  # commands that the first of several ranks does alone
OBJECTS = 300_000  # new ones between two looks for garbage
COMMANDS = {  # the module of each
    "list": "listing",
    "run": "run",
    "resume": "resuming",
    "study": "study",
    "info": "info",
    "render": "render",
    "report": "report_page",
    "export": "export",
    "bench": "bench",
    "numbers": "numbers",
    "doctor": "doctor",
}


def parser(command: str | None = None) -> argparse.ArgumentParser:
    """Return the parser of all commands, or of one: the others are not imported then."""
    top = argparse.ArgumentParser(
        prog="tcontact",
        description="Dynamic contact and impact of deformable solids.",
        epilog="exit code: 0 all well, 1 a run or one of its checks failed, 2 bad usage",
    )
    top.add_argument("--version", action="version", version=f"tcontact {__version__}")
    subparsers = top.add_subparsers(title="commands", dest="command", metavar="COMMAND", required=True)
    for module in COMMANDS.values() if command is None else (COMMANDS[command],):
        import_module(f".{module}", __package__).add(subparsers)
    top.set_defaults(main=main)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code; argv: the arguments, None = those of the process."""
    with safe_output() as output, rare_collections(last=argv is None):
        code = _run(argv)
        output.flush()
        if output.error is not None:
            print(f"tcontact: standard output cannot be written ({output.error.strerror})", file=sys.stderr)
            code = code or 1
    return code


@contextmanager
def rare_collections(last: bool = False) -> Iterator[None]:
    """Let Python look for cyclic garbage rarely: tracing and imports make many objects that stay, and little of it.

    last: the process ends with the command, and another look would only delay it: what is left goes with the process.
    """
    before = gc.get_threshold()
    gc.set_threshold(max(before[0], OBJECTS) if before[0] else 0, *before[1:])
    atexit.unregister(_leave)  # once, however many commands a process runs
    atexit.register(_leave)
    try:
        yield
    finally:
        if not last:
            gc.set_threshold(*before)


def _leave() -> None:
    """Store the compiled kernels, as Taichi does where its program is taken apart, and leave the rest as it is."""
    runtime.keep_kernels()
    gc.freeze()


def _run(argv: Sequence[str] | None) -> int:
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # it warns of a home folder that takes no files
    try:
        words = joined(sys.argv[1:] if argv is None else argv)
        arguments = parser(words[0] if words and words[0] in COMMANDS else None).parse_args(words)
    except SystemExit as stop:  # argparse: 0 for --help, 2 for bad usage
        return int(stop.code or 0)
    except KeyboardInterrupt as stop:  # while what the command needs is imported
        return _told(stop, "interrupted", 1)
    if arguments.command in ALONE:  # the other ranks wait for it at their end (last_words.py)
        return _done(arguments, _printed) if ranks.is_first_rank() else 0
    return _done(arguments, _told)


def _done(arguments: argparse.Namespace, tell: Callable[[BaseException, str, int], int]) -> int:
    """Do what a command is asked for, and return the exit code; tell: tells of an error and returns its code."""
    try:
        watched = arguments.command in TICKING and not getattr(arguments, "quiet", False) and ranks.is_first_rank()
        with terminations(), ticking(watched):
            stages.say("reading")
            return int(arguments.run(arguments))
    except InputError as error:
        return tell(error, str(error), 2)
    except (ImportError, OutputError) as error:
        return tell(error, str(error), 1)
    except MemoryError as error:
        return tell(error, f"there is not enough memory: {error or 'take fewer cells'}", 1)
    except KeyboardInterrupt as stop:
        return tell(stop, f"interrupted by {stop}" if isinstance(stop, Terminated) else "interrupted", 1)


def _told(error: BaseException, text: str, code: int) -> int:
    """Print why the command ends, once on several ranks, and return its exit code."""
    told(error, lambda: _printed(error, text, code), code)
    return code


def _printed(_error: BaseException, text: str, code: int) -> int:
    """Print why the command ends, and return its exit code."""
    print(f"tcontact: {text}", file=sys.stderr)
    return code
