"""Runs a command and converts any outcome to an exit code and one message."""

from __future__ import annotations

import argparse
import errno
import os
import re
import sys
from collections.abc import Callable, Sequence
from importlib import import_module

from tactile_maps.cli.parser import build_parser
from tactile_maps.cli.shared.output import StandardOutputError, flush_output, prepare_streams, print_error, print_json
from tactile_maps.cli.shared.outputs import outputs_checked
from tactile_maps.cli.shared.unused_options import refuse_unused_options
from tactile_maps.core.errors import ExportError, TactileMapsError, UsageError, describe_unexpected_error
from tactile_maps.core.interrupts import TerminatedError, signals_raised, terminal_closed

OpenWindow = Callable[[argparse.Namespace], int]
_FOLDERS = dict.fromkeys(("export", "recover", "replay", "trim"), "recordings")
"""Subfolders of ``commands`` by command."""


def run_command(argv: Sequence[str], *, windows: dict[str, OpenWindow]) -> int:
    """Run the command line.

    Args:
        argv: Words after the name of the program.
        windows: Commands that require the widgets, passed in so that this package does not depend on them.

    Returns:
        0 done, 1 failed, 2 bad usage, 130 interrupted (Ctrl-C), 143 ended by SIGTERM, 129 by SIGHUP or the closed
        terminal, 131 by SIGQUIT; none of these leaves a process behind.
    """
    prepare_streams()
    try:
        code = _run(argv, windows)
        flush_output()
    except StandardOutputError as error:
        if not error.closed_by_consumer:
            print_error(str(error))
        return 1
    except OSError:  # the terminal was closed
        return 128 + 1
    return code


def _run(argv: Sequence[str], windows: dict[str, OpenWindow]) -> int:
    try:
        arguments = build_parser().parse_args(_joined_negatives(argv))
    except SystemExit as stop:
        return int(stop.code or 0)
    command = arguments.command or "gui"
    as_json = getattr(arguments, "json", False)
    try:
        refuse_unused_options(command, arguments)
        with outputs_checked(arguments):
            if command in windows:
                return windows[command](arguments)
            with signals_raised():
                return int(import_module(_module_of(command)).execute(arguments))
    except StandardOutputError:
        raise
    except TactileMapsError as error:
        _print_failure(_with_notes(str(error), error), as_json, kind=type(error).__name__)
        return 2 if isinstance(error, UsageError) else 1
    except KeyboardInterrupt as stop:
        return _interrupted(stop, stop, as_json)
    except Exception as error:  # unexpected: the user gets a sentence, a file the details
        name = next(filter(_is_no_text, argv), None)
        if isinstance(error, UnicodeEncodeError) and name is not None:
            remedy = "Rename the file or folder"
            stated = ExportError(
                "a name is not valid UTF-8 and cannot be written into a file", file=name, remedy=remedy
            )
            _print_failure(str(stated), as_json, kind=type(stated).__name__)
            return 1
        interrupt = _interrupt_behind(error)
        if interrupt is None and isinstance(error, OSError) and terminal_closed():
            interrupt = TerminatedError(1)  # a message could not be written to the closed terminal
        if interrupt is not None:
            return _interrupted(interrupt, error, as_json)
        _print_failure(_with_notes(_text_of(error), error), as_json, kind="Unexpected")
        return 1


def _is_no_text(word: str) -> bool:
    """Return whether a word of the command line is not valid UTF-8: Python then keeps its bytes as surrogates."""
    try:
        word.encode()
    except UnicodeEncodeError:
        return True
    return False


_OPTION = re.compile(r"--[a-z-]+")
_NEGATIVE = re.compile(r"-[\d.]+[,e][\d.,e+-]*", re.IGNORECASE)


def _joined_negatives(argv: Sequence[str]) -> list[str]:
    """``--from -1,2,3`` as ``--from=-1,2,3``: argparse mistakes negative lists and powers of ten for options."""
    result = list[str]()
    for word in argv:
        if result and _OPTION.fullmatch(result[-1]) and _NEGATIVE.fullmatch(word):
            result[-1] += f"={word}"
        else:
            result.append(word)
    return result


_SYSTEM_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO, errno.ENAMETOOLONG)
"""Errors of the system, which the user can fix and a developer cannot."""


def _text_of(error: Exception) -> str:
    """Message of an unexpected error."""
    if isinstance(error, OSError) and error.errno in _SYSTEM_ERRORS:
        problem = "a file cannot be read or written"
        return str(TactileMapsError(problem, file=error.filename, value=error.strerror, remedy="Check path and space"))
    return describe_unexpected_error(error)


def _module_of(command: str) -> str:
    return ".".join(["tactile_maps.cli.commands", *([_FOLDERS[command]] if command in _FOLDERS else []), command])


def _interrupt_behind(error: BaseException | None) -> KeyboardInterrupt | None:
    """Return the interrupt that caused an error, which compiled libraries may replace by their own."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return error
        error = error.__cause__ or error.__context__
    return None


def _interrupted(stop: KeyboardInterrupt, error: BaseException, as_json: bool) -> int:
    _print_failure(_with_notes("interrupted", error), as_json, kind="Interrupted")
    return 128 + stop.number if isinstance(stop, TerminatedError) else 130


def _with_notes(text: str, error: BaseException) -> str:
    """Return a message with the notes of the error, such as which file was kept."""
    return "; ".join([text.removesuffix("."), *notes]) if (notes := getattr(error, "__notes__", ())) else text


def _print_failure(text: str, as_json: bool, *, kind: str) -> None:
    try:
        print_error(text)
        if as_json:
            print_json({"error": {"kind": kind, "message": text}})
        flush_output()
    except OSError:
        if not terminal_closed():
            raise
        nowhere = os.open(os.devnull, os.O_WRONLY)
        for stream in (sys.stdout, sys.stderr):
            os.dup2(nowhere, stream.fileno())
