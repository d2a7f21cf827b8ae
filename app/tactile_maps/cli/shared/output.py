"""Facts on standard output, progress and failures on standard error.

``prepare_streams`` makes both usable in any environment: closed, or with an encoding that lacks characters such as ².
Standard output that accepts no more data raises ``StandardOutputError``. A failure of standard error is not reported,
because there is no other place to report it.
"""

from __future__ import annotations

import codecs
import io
import json
import math
import os
import sys
import unicodedata
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import is_dataclass
from typing import Any, TextIO

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.core.interrupts import terminal_closed
from tactile_maps.core.progress import Progress

_PLAIN = {
    "°": " deg",
    "×": "x",
    "·": "*",
    "µ": "u",
    "π": "pi",
    "√": "sqrt",
    "±": "+/-",
    "−": "-",
    "–": "-",
    "—": "-",
    "→": "->",
    "←": "<-",
    "≤": "<=",
    "≥": ">=",
    "∞": "inf",
    "…": "...",
    "“": '"',
    "”": '"',
    "‘": "'",
    "’": "'",
}
"""Replacements in encodings that lack a character; others lose their accents or become a question mark."""
_ERRORS = "tactile-maps-plain"
"""Name of the handler of characters that an encoding lacks."""


class StandardOutputError(TactileMapsError):
    """Standard output that accepts no more data.

    Attributes:
        closed_by_consumer: Whether the program that reads it has ended, which is not reported.
    """

    def __init__(self, cause: OSError) -> None:
        self.closed_by_consumer = isinstance(cause, BrokenPipeError)
        value = cause.strerror
        remedy = "Free space, or write the output to another place"
        super().__init__("the output cannot be written", file="standard output", value=value, remedy=remedy)


def prepare_streams() -> None:
    """Open closed standard streams on the null device; make both output streams accept all characters."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:  # otherwise the next file that is opened would receive the output of libraries
            os.open(os.devnull, os.O_RDWR)
    sys.stdout = _usable(sys.stdout, 1)
    sys.stderr = _usable(sys.stderr, 2)


def _usable(stream: TextIO | None, number: int) -> TextIO:
    if stream is None:
        return open(number, "w", encoding="utf8", errors=_ERRORS, closefd=False)
    if isinstance(stream, io.TextIOWrapper):
        stream.reconfigure(errors=_ERRORS)
    return stream


def _plain_characters(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_plain_character, error.object[error.start : error.end])), error.end


def _plain_character(character: str) -> str:
    known = _PLAIN.get(character)
    return known or unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode() or "?"


codecs.register_error(_ERRORS, _plain_characters)


def write_output(text: str) -> None:
    """Write text to standard output.

    Raises:
        StandardOutputError: It cannot be written.
    """
    try:
        sys.stdout.write(text)
    except OSError as error:
        raise _output_lost(error) from error


def flush_output() -> None:
    """Write buffered text.

    Raises:
        StandardOutputError: It cannot be written.
    """
    try:
        sys.stdout.flush()
    except OSError as error:
        raise _output_lost(error) from error


def _output_lost(error: OSError) -> OSError | StandardOutputError:
    """The error to raise; buffered text is discarded, so that the end of the program does not fail again."""
    if terminal_closed():
        return error
    _discard(sys.stdout)
    return StandardOutputError(error)


def _discard(stream: TextIO) -> None:
    with suppress(OSError):  # a stream without a file has nothing to discard
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def write_error(text: str) -> None:
    """Write text to standard error; it is lost where that fails."""
    try:
        sys.stderr.write(text)
        sys.stderr.flush()
    except OSError:
        if terminal_closed():
            raise
        _discard(sys.stderr)


def print_line(text: str) -> None:
    """Print a line for a person."""
    write_output(text + "\n")


def print_result(result: Mapping[str, Any], rows: Mapping[str, object], *, as_json: bool) -> None:
    """Print a result as one JSON object for a program, otherwise its facts ``rows`` for a person."""
    if as_json:
        print_json(result)
    else:
        print_fields(rows)


def print_fields(rows: Mapping[str, object]) -> None:
    """Print aligned facts for a person, without those that are None."""
    width = max((len(name) for name in rows), default=0)
    for name, value in rows.items():
        if value is not None:
            print_line(f"{name:<{width}}  {plain_text(value)}")


def plain_text(value: object) -> str:
    """Return a fact as text: numbers with four digits, groups separated by commas."""
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, dict):
        return ", ".join(f"{key} {plain_text(item)}" for key, item in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(plain_text(item) for item in value)
    return str(value)


def print_json(result: Mapping[str, Any]) -> None:
    """Print one object on one line, for a program; NaN and infinity, which JSON lacks, become null."""
    write_output(json.dumps(_json_value(result), allow_nan=False) + "\n")


def print_error(text: str) -> None:
    """Print a failure on standard error."""
    write_error(f"tactile-maps: {text}\n")


def print_warning(text: str) -> None:
    """Print a warning on standard error."""
    write_error(f"tactile-maps: warning: {text}\n")


def progress_line() -> Progress:
    """Return a progress line for a terminal; a function without effect where standard error is a file."""
    if not sys.stderr.isatty():
        return lambda _text, _fraction: None

    def report(text: str, fraction: float) -> None:
        write_error(f"\r\x1b[K{100 * fraction:3.0f} %  {text}" + ("\r\x1b[K" if fraction >= 1.0 else ""))

    return report


def _json_value(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _json_value(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_json_value(item) for item in value]
    if is_dataclass(value) and not isinstance(value, type):
        return _json_value(vars(value))
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if hasattr(value, "item"):
        return _json_value(value.item())
    return value
