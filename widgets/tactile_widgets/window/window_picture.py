"""Picture of the window as a file."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QBuffer
from PySide6.QtGui import QImageWriter
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import DisplayError
from tactile_maps.core.files import write_atomically


def check_picture_kind(path: str | Path) -> str:
    """Return the format of a picture's file, which is PNG without an extension.

    Raises:
        DisplayError: The format cannot be written.
    """
    kind = Path(path).suffix.removeprefix(".").lower() or "png"
    if kind not in (bytes(known.data()).decode() for known in QImageWriter.supportedImageFormats()):
        raise DisplayError("pictures of this kind cannot be written", file=path, remedy="Choose a name ending in .png")
    return kind


def save_window_picture(window: QWidget, path: str | Path) -> None:
    """Write a picture of the window, as PNG or in the format of the file name (.jpg, .bmp...).

    Raises:
        DisplayError: The file name has no known picture format, or the file cannot be written.
    """
    kind = check_picture_kind(path)
    picture = QBuffer()
    picture.open(QBuffer.OpenModeFlag.WriteOnly)
    window.grab().save(picture, kind)
    write_atomically(Path(path), bytes(picture.data().data()), error=DisplayError)
