"""Runs a command and turns whatever happens into an exit code and one message."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module

from app.cli.output import print_error, print_json
from app.cli.parser import build_parser
from app.core.errors import TactileMapsError, UsageError, describe_unexpected_error

OpenWindow = Callable[[argparse.Namespace], int]
_FOLDERS = dict.fromkeys(("export", "recover", "replay", "trim"), "recordings")
"""Of ``commands``, where a command does not lie there itself."""


def run_command(argv: Sequence[str], *, windows: dict[str, OpenWindow]) -> int:
    """Do what the command line asks.

    Args:
        argv: Words after the program's name.
        windows: The commands that need the widgets, handed in so that this package stays without them.

    Returns:
        0 done, 1 failed, 2 bad usage, 130 interrupted (Ctrl-C), 143 ended by SIGTERM; either leaves no process behind.
    """
    try:
        arguments = build_parser().parse_args(argv)
    except SystemExit as stop:
        return int(stop.code or 0)
    command = arguments.command or "gui"
    as_json = getattr(arguments, "json", False)
    try:
        if command in windows:
            return windows[command](arguments)
        with _terminating_as_ctrl_c():
            return int(import_module(_module_of(command)).execute(arguments))
    except TactileMapsError as error:
        _print_failure(str(error), as_json, kind=type(error).__name__)
        return 2 if isinstance(error, UsageError) else 1
    except KeyboardInterrupt as stop:
        _print_failure("interrupted", as_json, kind="Interrupted")
        return 143 if isinstance(stop, _TerminatedError) else 130
    except BrokenPipeError:
        # Whoever read our output has gone; nothing more can be said.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except Exception as error:  # the last door: a person gets a sentence, the details go to a file
        if _was_interrupted(error):
            _print_failure("interrupted", as_json, kind="Interrupted")
            return 130
        _print_failure(describe_unexpected_error(error), as_json, kind="Unexpected")
        return 1


def _module_of(command: str) -> str:
    return ".".join(["app.cli.commands", *([_FOLDERS[command]] if command in _FOLDERS else []), command])


def _was_interrupted(error: BaseException | None) -> bool:
    """Whether Ctrl-C is behind it: compiled libraries turn what is raised in their callbacks into their own errors."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False


class _TerminatedError(KeyboardInterrupt):
    """SIGTERM, as of a batch system whose time is over: everything is put away as after Ctrl-C."""


@contextmanager
def _terminating_as_ctrl_c() -> Iterator[None]:
    def stop(*_: object) -> None:
        raise _TerminatedError

    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread may say what a signal does
        return
    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _print_failure(text: str, as_json: bool, *, kind: str) -> None:
    print_error(text)
    if as_json:
        print_json({"error": {"kind": kind, "message": text}})
