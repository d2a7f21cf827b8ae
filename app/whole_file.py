"""Files read whole and bounded, and written whole or not at all; always named in errors."""

from __future__ import annotations

from pathlib import Path

from app.errors import TactileMapsError


def read_whole(path: Path, *, error: type[TactileMapsError], most: int) -> bytes:
    """The whole file.

    Raises:
        TactileMapsError: Of kind ``error``: it cannot be read, or has more than ``most`` bytes.
    """
    try:
        size = path.stat().st_size
        if size > most:
            raise error(
                "the file is too large", file=path, value=f"{size} bytes", remedy=f"The most is {most // 2**20} MiB"
            )
        return path.read_bytes()
    except (OSError, ValueError) as cause:
        raise error("the file cannot be read", file=path, value=cause, remedy="Check the path") from cause


def write_whole(path: Path, data: bytes, *, error: type[TactileMapsError]) -> None:
    """Put ``data`` into the file at ``path``, or leave what was there.

    Raises:
        TactileMapsError: Of kind ``error``: it cannot be written.
    """
    part = path.with_name(path.name + ".part")
    try:
        part.write_bytes(data)
        part.replace(path)
    except (OSError, ValueError) as cause:
        raise error(
            "the file cannot be written",
            file=path,
            value=cause,
            remedy="Choose a folder you may write to, with space left",
        ) from cause
