"""Log of finished cases, one line of JSON each, so that no measurement is lost or repeated.

A case is identified by a digest of its settings, its measurement and the program (see ``case_key``). Its line is
written as soon as it is finished and passed to the operating system at once, so that any end of the program, ``kill
-9`` included, loses at most the line being written. Damaged lines are ignored. The last line of a finished run marks
its end. A log with cases is replaced only on request.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Sequence
from functools import cache, partial
from hashlib import blake2b
from io import FileIO
from pathlib import Path
from typing import Any

from tactile_maps.core.errors import ExportError, UsageError
from tactile_maps.core.files import lock_file, make_output_folder, output_path
from tactile_maps.session.program_digest import program_digest
from tactile_maps.studies.base.rows import Case, Measure, Row

_NO_ROWS = ("cli", "export", "live")
"""Packages above studies and recordings, whose changes do not affect rows."""
_PACKAGE = Path(__file__).parents[2]
_REMEDY = "--resume continues it, --overwrite replaces it"


def case_key(name: str, measure: Measure, case: Case) -> str:
    """Return the key of a case: equal for the same settings, the same program and the same study.

    Args:
        name: Name of the study.
        measure: Measurement, a function of a module; a ``partial`` counts as its function.
        case: Settings of the case, of types that JSON supports.

    Raises:
        UsageError: The settings contain another type.
    """
    try:
        settings = json.dumps(case, sort_keys=True, separators=(",", ":"))
    except TypeError as error:
        raise UsageError("a case must contain only numbers and words", place=name, value=case) from error
    return _digest(f"{name}\0{measuring_program(measure)}\0{settings}".encode())


def measuring_program(measure: Measure) -> str:
    """Return a digest of the program, and of the module of the measurement if that is outside of it."""
    return _program_of(measure.func if isinstance(measure, partial) else measure)


@cache
def _program_of(function: Any) -> str:
    source = inspect.getsourcefile(inspect.unwrap(function))
    outside = source is not None and _PACKAGE not in Path(source).parents
    return program_digest(without=_NO_ROWS) + (_digest(Path(source).read_bytes()) if source and outside else "")


def _digest(data: bytes) -> str:
    return blake2b(data, digest_size=16).hexdigest()


class CaseLog:
    """Log of one run, locked against other processes until it is closed.

    Attributes:
        path: The file, one line a case.
        done: Rows of each finished case, by its key.
        torn: Number of unreadable lines; their cases are measured again.
    """

    def __init__(self, path: Path, *, resume: bool = False, overwrite: bool = False) -> None:
        """Open or create the file and its folder.

        Args:
            path: The file.
            resume: Whether cases in the file count as finished.
            overwrite: Whether a run in the file may be replaced.

        Raises:
            ExportError: It cannot be read or written.
            UsageError: Another process writes it, or it contains a run and neither ``resume`` nor ``overwrite`` is set.
        """
        self.path = path
        self._stream = _open(path)
        try:
            self.done, self.torn, ended = _read(self._stream)
            if not resume:
                if self.done and not overwrite:
                    problem = f"the folder contains {'a finished' if ended else 'an interrupted'} run"
                    raise UsageError(problem, file=path, value=f"{len(self.done)} cases", remedy=_REMEDY)
                self._stream.truncate(0)
                self.done = {}
                self.torn = 0
        except BaseException:
            self._stream.close()
            raise

    def keep(self, key: str, rows: Sequence[Row]) -> None:
        """Store the rows of a finished case.

        Raises:
            ExportError: It cannot be written.
        """
        self.done[key] = list(rows)
        self._write({"case": key, "rows": rows})

    def end(self) -> None:
        """Mark the run as finished.

        Raises:
            ExportError: It cannot be written.
        """
        self._write({"ended": True})

    def close(self) -> None:
        """Close the file, so that other processes can write it."""
        self._stream.close()

    def _write(self, line: object) -> None:
        data = json.dumps(line, separators=(",", ":")).encode() + b"\n"
        try:
            whole = self._stream.write(data) == len(data)
        except OSError as error:
            raise ExportError("the cases cannot be written", file=self.path, value=error.strerror) from error
        if not whole:
            raise ExportError("the cases cannot be written", file=self.path, value="the disk is full")


def _open(path: Path) -> FileIO:
    """Open a file for reading and appending, unbuffered and locked."""
    make_output_folder(path.parent, error=ExportError)
    output_path(path, error=ExportError)
    try:
        stream = open(path, "a+b", buffering=0)  # noqa: SIM115 - it stays open as long as the log
    except OSError as error:
        raise ExportError("the cases cannot be written", file=path, value=error.strerror) from error
    if not lock_file(stream.fileno()):
        stream.close()
        raise UsageError("another run writes here", file=path, remedy="Wait for its end, or choose another folder")
    return stream


def _read(stream: FileIO) -> tuple[dict[str, list[Row]], int, bool]:
    """Rows by case, number of damaged lines, and whether the run is finished; an incomplete last line is removed."""
    stream.seek(0)
    done: dict[str, list[Row]] = {}
    torn = 0
    ended = False
    whole = 0
    for line in stream.readall().splitlines(keepends=True):
        if not line.endswith(b"\n"):
            break
        whole += len(line)
        try:
            entry = json.loads(line)
            ended = entry.get("ended", False) is True
            if not ended:
                done[entry["case"]] = entry["rows"]
        except (ValueError, KeyError, AttributeError, TypeError):
            torn = torn + 1
            ended = False
    stream.truncate(whole)
    return done, torn, ended
