"""Compares the drawing of a widget with a picture stored with the tests; small rasterisation differences are allowed.

Size, font, style and scale are fixed. ``TACTILE_MAPS_UPDATE_SNAPSHOTS=1`` writes new pictures; look at them before you
keep them.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QWidget

FOLDER = Path(__file__).resolve().parents[2] / "snapshots"


def pixels(image: QImage) -> np.ndarray:
    """(h, w, 3) int16 red, green, blue."""
    image = image.convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), image.bytesPerLine())
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(np.int16)


def shared_share(one: np.ndarray, other: np.ndarray, *, tolerance: int) -> float:
    """Share of pixels whose channels differ by at most ``tolerance`` of 255."""
    return float((np.abs(one - other).max(axis=2) <= tolerance).mean())


def check_picture(widget: QWidget, name: str, *, tolerance: int = 24, share: float = 0.985) -> None:
    """Assert that ``widget`` looks like ``snapshots/name.png``: ``share`` of its pixels within ``tolerance``.

    On failure the new picture is written next to the old one as ``name.new.png``.
    """
    drawn = widget.grab().toImage()
    kept = FOLDER / f"{name}.png"
    if os.environ.get("TACTILE_MAPS_UPDATE_SNAPSHOTS") == "1":
        FOLDER.mkdir(exist_ok=True)
        assert drawn.save(str(kept))
        return
    assert kept.exists(), f"no picture {kept}; write it with TACTILE_MAPS_UPDATE_SNAPSHOTS=1"
    expected = pixels(QImage(str(kept)))
    got = pixels(drawn)
    assert got.shape == expected.shape, "the pinned size differs; is the display scaled?"
    same = shared_share(got, expected, tolerance=tolerance)
    if same < share:
        drawn.save(str(FOLDER / f"{name}.new.png"))
    assert same >= share, f"{name}: only {100 * same:.2f} % of the pixels agree"
