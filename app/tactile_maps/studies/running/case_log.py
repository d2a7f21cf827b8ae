"""The cases that are done, each a line of JSON, so that nothing that was measured is lost or measured twice.

A case is known by a digest of its settings, of what measures it and of the program that does (see ``case_key``). A line
is written when its case is done and handed to the operating system at once: whatever ends the program, ``kill -9`` too,
costs no line but the one being written. A torn line is ignored. The last line of a finished run says so. A log with
cases is replaced only on request.
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
"""Packages that lie above studies and recordings: what they do changes no row."""
_PACKAGE = Path(__file__).parents[2]
_AGAIN = "--resume continues it, --overwrite replaces it"


def case_key(name: str, measure: Measure, case: Case) -> str:
    """A case's name: the same for the same settings, asked of the same program, in the same study.

    Args:
        name: Of the study.
        measure: What measures it, a function of a module; a ``partial`` of one counts as it does.
        case: Its settings, made of what JSON knows.

    Raises:
        UsageError: Its settings hold something else.
    """
    try:
        settings = json.dumps(case, sort_keys=True, separators=(",", ":"))
    except TypeError as error:
        raise UsageError("a case holds what is neither number nor word", place=name, value=case) from error
    return _digest(f"{name}\0{measuring_program(measure)}\0{settings}".encode())


def measuring_program(measure: Measure) -> str:
    """A digest of the program, and of the module that measures where it lies outside."""
    return _program_of(measure.func if isinstance(measure, partial) else measure)


@cache
def _program_of(function: Any) -> str:
    source = inspect.getsourcefile(inspect.unwrap(function))
    outside = source is not None and _PACKAGE not in Path(source).parents
    return program_digest(without=_NO_ROWS) + (_digest(Path(source).read_bytes()) if source and outside else "")


def _digest(data: bytes) -> str:
    return blake2b(data, digest_size=16).hexdigest()


class CaseLog:
    """The log of one run, which nobody else may write meanwhile; to be closed.

    Attributes:
        path: The file, one line a case.
        done: Rows of each case that is done, by its key.
        torn: Lines that could not be read; their cases are measured again.
    """

    def __init__(self, path: Path, *, resume: bool = False, overwrite: bool = False) -> None:
        """Open or make the file, and the folder it is in.

        Args:
            path: The file.
            resume: Whether what it holds is taken for done.
            overwrite: Whether a run that it holds may be replaced.

        Raises:
            ExportError: It cannot be read or written.
            UsageError: Another process writes it, or it holds a run, and neither ``resume`` nor ``overwrite`` is set.
        """
        self.path = path
        self._stream = _open(path)
        try:
            self.done, self.torn, ended = _read(self._stream)
            if not resume:
                if self.done and not overwrite:
                    problem = f"the folder contains {'a finished' if ended else 'an interrupted'} run"
                    raise UsageError(problem, file=path, value=f"{len(self.done)} cases", remedy=_AGAIN)
                self._stream.truncate(0)
                self.done = {}
                self.torn = 0
        except BaseException:
            self._stream.close()
            raise

    def keep(self, key: str, rows: Sequence[Row]) -> None:
        """A case is done.

        Raises:
            ExportError: It cannot be written.
        """
        self.done[key] = list(rows)
        self._write({"case": key, "rows": rows})

    def end(self) -> None:
        """The run has come to its end: the next one may begin anew.

        Raises:
            ExportError: It cannot be written.
        """
        self._write({"ended": True})

    def close(self) -> None:
        """Let others write it."""
        self._stream.close()

    def _write(self, line: object) -> None:
        data = json.dumps(line, separators=(",", ":")).encode() + b"\n"
        try:
            whole = self._stream.write(data) == len(data)
        except OSError as error:
            raise ExportError("the cases cannot be kept", file=self.path, value=error.strerror) from error
        if not whole:
            raise ExportError("the cases cannot be kept", file=self.path, value="the disk is full")


def _open(path: Path) -> FileIO:
    """To be read and appended to, unbuffered, and locked."""
    make_output_folder(path.parent, error=ExportError)
    output_path(path, error=ExportError)
    try:
        stream = open(path, "a+b", buffering=0)  # noqa: SIM115 - it lives as long as the log
    except OSError as error:
        raise ExportError("the cases cannot be kept", file=path, value=error.strerror) from error
    if not lock_file(stream.fileno()):
        stream.close()
        raise UsageError("another run writes here", file=path, remedy="Let it end, or choose another folder")
    return stream


def _read(stream: FileIO) -> tuple[dict[str, list[Row]], int, bool]:
    """Rows by case, how many lines are torn, and whether the run came to its end; a torn tail is cut off."""
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
            told = json.loads(line)
            ended = told.get("ended", False) is True
            if not ended:
                done[told["case"]] = told["rows"]
        except (ValueError, KeyError, AttributeError, TypeError):
            torn = torn + 1
            ended = False
    stream.truncate(whole)
    return done, torn, ended
