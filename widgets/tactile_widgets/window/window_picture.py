"""Picture of the window as a file."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QBuffer
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import DisplayError
from tactile_maps.core.files import write_atomically


def save_window_picture(window: QWidget, path: str | Path) -> None:
    """Write a picture of the window, as PNG or in the format of the file name (.jpg, .bmp...).

    Raises:
        DisplayError: The file name has no known picture format, or the file cannot be written.
    """
    path = Path(path)
    picture = QBuffer()
    picture.open(QBuffer.OpenModeFlag.WriteOnly)
    kind = path.suffix.removeprefix(".").upper() or "PNG"
    if not window.grab().save(picture, kind):
        raise DisplayError("pictures of this kind cannot be written", file=path, remedy="Choose a name ending in .png")
    write_atomically(path, bytes(picture.data().data()), error=DisplayError)
