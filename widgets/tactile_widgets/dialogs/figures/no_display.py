"""Qt without a display, for pictures and films."""

from __future__ import annotations

import os
import sys

from PySide6.QtCore import QMessageLogContext, QtMsgType, qInstallMessageHandler


def use_no_display() -> None:
    """Use Qt's platform for pictures, without its message that it has no window manager for the limits of sizes."""
    os.environ["QT_QPA_PLATFORM"] = "offscreen"
    qInstallMessageHandler(_on_qt_message)


def _on_qt_message(_kind: QtMsgType, _context: QMessageLogContext, text: str) -> None:
    if "does not support propagateSizeHints" not in text:
        sys.stderr.write(f"{text}\n")
