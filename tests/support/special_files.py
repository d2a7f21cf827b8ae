"""Special files in a test's folder. Tests never write to devices of the machine."""

from __future__ import annotations

import os
import socket
import stat
from pathlib import Path


def make_special_file(kind: str, path: Path) -> Path:
    """Make a pipe, a socket or a device at ``path``; return it."""
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "socket":
        before = Path.cwd()
        os.chdir(path.parent)  # a socket's whole path has at most about 100 characters
        try:
            with socket.socket(socket.AF_UNIX) as bound:
                bound.bind(path.name)
        finally:
            os.chdir(before)
    else:
        os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, 3))
    return path


def special_kinds() -> tuple[str, ...]:
    """Return the kinds that can be made: devices need root and a suitable file system."""
    return ("pipe", "socket", *(("device",) if _can_make_devices() else ()))


def is_special(path: Path) -> bool:
    """Whether the file is neither a regular file nor a folder."""
    mode = path.lstat().st_mode
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def _can_make_devices() -> bool:
    path = Path(os.environ.get("TMPDIR", "/tmp")) / f"tactile-maps-test-device-{os.getpid()}"
    try:
        make_special_file("device", path)
    except OSError:
        return False
    path.unlink()
    return True
