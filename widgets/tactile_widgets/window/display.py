"""Whether a window can be opened: asked before Qt, which ends the process where it cannot instead of saying so.

Apart from ``application``, whose imports are the whole window: who has no display is told without waiting for them.
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
    """Return when there is a display that answers and Qt can draw on it; costs a few milliseconds.

    Asked on Linux alone: elsewhere whoever runs a program has a desktop.

    Raises:
        DisplayError: None is named, the one that is does not answer, or a library that Qt needs for it is missing.
    """
    chosen = os.environ.get("QT_QPA_PLATFORM", "").split(":")[0]
    if not sys.platform.startswith("linux") or chosen not in _ON_SCREEN:
        return
    named = {name: os.environ[name] for name in ("DISPLAY", "WAYLAND_DISPLAY") if os.environ.get(name)}
    if not named:
        raise DisplayError(
            "there is no display to open a window on",
            place="DISPLAY, WAYLAND_DISPLAY",
            value="not set",
            remedy=_REMEDY,
        )
    if "WAYLAND_DISPLAY" in named and _wayland_answers(named["WAYLAND_DISPLAY"]):
        return
    if not ("DISPLAY" in named and _x11_answers()):
        text = ", ".join(f"{name}={value}" for name, value in named.items())
        raise DisplayError("the display does not answer", value=text, remedy=_REMEDY)
    _require_xcb_libraries()


def _wayland_answers(name: str) -> bool:
    with socket.socket(socket.AF_UNIX) as end:
        try:
            end.connect(str(Path(os.environ.get("XDG_RUNTIME_DIR", "/")) / name))
        except OSError:
            return False
    return True


def _x11_answers() -> bool:
    """Ask as Qt will: through libxcb, which knows about hosts, numbers and permissions."""
    try:
        xcb = ctypes.CDLL(ctypes.util.find_library("xcb") or "libxcb.so.1")
    except OSError:
        return True  # it is among the libraries asked for by name next
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
            "Qt misses a library for this display",
            value=error,
            remedy="Install it; on Debian assets/install/install.sh installs all of them",
        ) from error
