"""Check for a display before Qt starts, because Qt ends the process without one.

The check is separate from ``application``, which imports the whole window, so that the error appears quickly.
"""

from __future__ import annotations

import ctypes.util
import os
import socket
import sys
from pathlib import Path

from PySide6.QtCore import QLibraryInfo

from tactile_maps.core.errors import DisplayError

_REMEDY = "Run it in a desktop session or under xvfb-run; run, replay and screenshot need no display"
_ON_SCREEN = ("", "xcb", "wayland")


def require_display() -> None:
    """Check that a display responds and that Qt can draw on it; takes a few milliseconds.

    Checked on Linux only: other systems always have a desktop.

    Raises:
        DisplayError: No display is set, it does not respond, or a library that Qt needs for it is missing.
    """
    chosen = os.environ.get("QT_QPA_PLATFORM", "").split(":")[0]
    if not sys.platform.startswith("linux") or chosen not in _ON_SCREEN:
        return
    named = {name: os.environ[name] for name in ("DISPLAY", "WAYLAND_DISPLAY") if os.environ.get(name)}
    if not named:
        raise DisplayError(
            "no display to open a window on",
            place="DISPLAY, WAYLAND_DISPLAY",
            value="not set",
            remedy=_REMEDY,
        )
    if "WAYLAND_DISPLAY" in named and _wayland_responds(named["WAYLAND_DISPLAY"]):
        return
    if not ("DISPLAY" in named and _x11_responds()):
        text = ", ".join(f"{name}={value}" for name, value in named.items())
        raise DisplayError("the display does not respond", value=text, remedy=_REMEDY)
    _require_xcb_libraries()


def _wayland_responds(name: str) -> bool:
    with socket.socket(socket.AF_UNIX) as end:
        try:
            end.connect(str(Path(os.environ.get("XDG_RUNTIME_DIR", "/")) / name))
        except OSError:
            return False
    return True


def _x11_responds() -> bool:
    """Connect like Qt, through libxcb, which handles hosts, numbers and permissions."""
    try:
        xcb = ctypes.CDLL(ctypes.util.find_library("xcb") or "libxcb.so.1")
    except OSError:
        return True  # reported next, among the libraries
    xcb.xcb_connect.restype = ctypes.c_void_p
    connection = ctypes.c_void_p(xcb.xcb_connect(None, None))
    failed = bool(xcb.xcb_connection_has_error(connection))
    xcb.xcb_disconnect(connection)
    return not failed


def _require_xcb_libraries() -> None:
    plugin = Path(QLibraryInfo.path(QLibraryInfo.LibraryPath.PluginsPath)) / "platforms" / "libqxcb.so"
    try:
        ctypes.CDLL(str(plugin))
    except OSError as error:
        raise DisplayError(
            "a library that Qt needs for this display is missing",
            value=error,
            remedy="Install it; on Debian assets/install/install.sh installs all of them",
        ) from error
