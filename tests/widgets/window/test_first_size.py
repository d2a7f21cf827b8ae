"""The first window fits its screen with its frame, at any scale."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QMargins, QRect, QSize
from PySide6.QtWidgets import QApplication

from tactile_widgets.window.main_window import PREFERRED_SIZE, first_rectangle


@pytest.mark.parametrize(
    "room",
    [QRect(0, 0, 1366, 728), QRect(0, 27, 910, 485), QRect(1920, 0, 1280, 800), QRect(0, 0, 1400, 900)],
    ids=["laptop", "laptop at scale 1.5", "second screen", "preferred size, except for the frame"],
)
def test_first_size_fits_with_the_frame(room):
    place = first_rectangle(room)
    assert room.contains(place.marginsAdded(QMargins(8, 40, 8, 8)))
    assert place.width() >= room.width() - 16 or place.width() == PREFERRED_SIZE.width()


def test_preferred_size_is_centred_on_a_large_screen():
    place = first_rectangle(QRect(0, 0, 2560, 1440))
    assert place.size() == PREFERRED_SIZE
    assert (place.center() - QRect(0, 0, 2560, 1440).center()).manhattanLength() <= 2


@pytest.mark.long
def test_small_window_shows_everything(window):
    window.resize(QSize(900, 600))
    QApplication.processEvents()  # the plots give room
    assert window.size() == QSize(900, 600)
    assert window.minimumSizeHint().height() <= 480, "a laptop of 768 px at scale 1.5"
