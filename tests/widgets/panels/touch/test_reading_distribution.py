"""The histogram of readings: a taxel is right of the threshold exactly if it is in contact."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor
from PySide6.QtTest import QTest

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.live.session.measured_session import ReadingLevels
from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.panels.touch.reading_distribution import ReadingDistribution, axis_place


def test_axis_rises_and_ends_at_its_limits():
    places = axis_place(np.array([-1e6, -10.0, -1.0, 0.0, 1.0, 10.0, 100.0, 1e9]))
    assert (np.diff(places) >= 0).all()
    assert (np.diff(places[1:-1]) > 0.05).all()
    assert (places[0], places[-1]) == (0.0, 1.0)


@pytest.mark.parametrize("theme", [DARK, LIGHT], ids=lambda theme: theme.name)
def test_taxels_in_contact_are_painted_in_the_accent(qtbot, theme):
    part = ReadingDistribution()
    qtbot.addWidget(part)
    part.set_theme(theme)
    part.resize(300, 160)
    quiet = 40.0 * np.random.default_rng(0).standard_normal(100)
    for touched in (0, 7):
        readings = np.concatenate([quiet, np.full(touched, 4e3), [np.nan]])
        levels = ReadingLevels(readings, np.full(len(readings), 200.0), np.full(len(readings), 40.0))
        part.show_levels(levels, ReadingUnits.CALIBRATED)
        picture = part.view.grab().toImage()
        colours = {picture.pixel(x, y) for x in range(picture.width()) for y in range(picture.height())}
        assert (QColor(theme.accent).rgb() in colours) is bool(touched)
        assert part.view.counts.sum() == 100 + touched, "a taxel without a value is left out"


def test_readings_without_tare_state_that_the_noise_is_unknown(qtbot):
    part = ReadingDistribution()
    qtbot.addWidget(part)
    part.show_levels(ReadingLevels(np.zeros(3), np.full(3, 1e3), None), ReadingUnits.COUNTS)
    assert "Noise unknown" in part.caption
    part.show_levels(ReadingLevels(np.full(3, np.nan), np.full(3, 1e3), None), ReadingUnits.COUNTS)
    assert part.caption == "No reading yet."


def test_choice_of_contacts_side_by_side_is_shown_and_edited(qtbot):
    part = ReadingDistribution()
    qtbot.addWidget(part)
    part.show_reading(ReadingSettings(close_contacts="joined", above_noise=4.0))
    assert part.close_contacts.currentText() == "Join connected taxels"
    with qtbot.waitSignal(part.reading_edited) as edited:
        QTest.keyClick(part.close_contacts, Qt.Key.Key_Up)
        part.close_contacts.activated.emit(part.close_contacts.currentIndex())
    assert edited.args == [ReadingSettings(close_contacts="separate", above_noise=4.0)]
