"""Files of other programs: read whole and bounded, written whole or not at all, and always named in errors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from app.core.errors import Finding, SkinError, TactileMapsError
from app.core.files import read_bounded_file, write_atomically

MAX_BYTES = 64 * 2**20
MAX_TAXELS = 100_000


def read_bytes(path: Path, *, error: type[TactileMapsError] = SkinError, most: int = MAX_BYTES) -> bytes:
    """The whole file; see ``read_bounded_file``."""
    return read_bounded_file(path, error=error, most=most)


def write_bytes(path: Path, data: bytes, *, error: type[TactileMapsError] = SkinError) -> None:
    """The whole file or nothing; see ``write_atomically``."""
    write_atomically(path, data, error=error)


def read_text(path: Path, *, error: type[TactileMapsError] = SkinError, most: int = MAX_BYTES) -> str:
    """The whole file as text; bytes that are not UTF-8 become the replacement character and fail where they matter."""
    return read_bytes(path, error=error, most=most).decode("utf-8-sig", errors="replace")


def write_lines(path: Path, lines: Iterable[str], *, error: type[TactileMapsError] = SkinError) -> None:
    """Put ``lines`` into the text file at ``path``, or leave what was there; errors as ``write_bytes``."""
    write_bytes(path, ("\n".join(lines) + "\n").encode(errors="replace"), error=error)


@contextmanager
def errors_in_file(file: str | Path) -> Iterator[None]:
    """Errors raised inside that name no file name this one."""
    try:
        yield
    except TactileMapsError as error:
        if error.file is not None:
            raise
        raise type(error)(
            error.problem, file=file, place=error.place, value=error.value, remedy=error.remedy
        ) from error


def add_finding(findings: list[Finding], kind: str, where: str, action: str, count: int) -> None:
    """Add a finding where there is something to count."""
    if count:
        findings.append(Finding(kind, where, action, count))
