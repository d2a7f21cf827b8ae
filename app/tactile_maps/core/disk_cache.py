"""Entries of the cache folder: read if valid, written atomically, the least recently used deleted first."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.core.files import ZIP_DAMAGE, write_atomically

T = TypeVar("T")
_log = logging.getLogger(__name__)


def read_entry(path: Path, read: Callable[[], T | None]) -> T | None:
    """Return the result of ``read`` and mark the entry as used; None without an entry, or if it is damaged."""
    if not os.path.isfile(path):
        return None
    try:
        found = read()
    except (*ZIP_DAMAGE, KeyError, ValueError, TactileMapsError) as damage:
        _log.info("A cache entry cannot be used and is made again: %s: %s", path, damage)
        return None
    if found is not None:
        try:
            os.utime(path)
        except OSError:
            _log.info("The cache folder is not writable: %s", path.parent)
    return found


def store_entry(path: Path, content: Callable[[], bytes], *, suffixes: Iterable[str], most: int) -> None:
    """Write an entry and delete the least recently used ones with ``suffixes`` beyond ``most`` bytes.

    A failure only costs time later.
    """
    try:
        data = content()
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, data, error=TactileMapsError)
        total = 0
        for entry, _used, size in sorted(entries(path.parent, suffixes), key=lambda entry: entry[1], reverse=True):
            total += size
            if total > most:
                entry.unlink(missing_ok=True)
    except (OSError, TactileMapsError) as failure:
        _log.info("A cache entry could not be stored: %s", failure)


def entries(folder: Path, suffixes: Iterable[str]) -> list[tuple[Path, int, int]]:
    """Return path, time of the last use [ns] and size [bytes] of each entry with ``suffixes``."""
    found = []
    for suffix in suffixes:
        for path in folder.glob(f"*{suffix}"):
            try:
                status = path.stat()
            except FileNotFoundError:  # deleted by another process
                continue
            found.append((path, status.st_mtime_ns, status.st_size))
    return found
