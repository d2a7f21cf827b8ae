"""Units are defined in one place; readings without calibration give no force."""

from __future__ import annotations

import pytest

from tactile_maps.core.reading_units import ReadingUnits


def test_calibrated_readings_are_kilopascals_and_newtons():
    units = ReadingUnits.CALIBRATED
    assert (units.unit, units.force, units.title, units.axis_label) == ("kPa", "N", "Pressure (kPa)", "pressure [kPa]")
    assert units.reading(4200.0) == "4.2\u202fkPa"
    assert units.force_words(1.234, 2) == units.contact_words(1.234, 4e3, 2) == "1.23\u202fN"
    assert units.strength_title == "Contact force (N)"


@pytest.mark.parametrize("units", [ReadingUnits.COUNTS, ReadingUnits.PRESSURE])
def test_strength_without_force_is_the_highest_reading(units):
    assert units.force is None
    assert units.force_words(1.2) is None
    assert units.contact_words(1.2, 60_000.0) == f"60\u202f{units.unit}"
    assert units.strength_title == "Contact strength (relative)"


def test_counts_are_not_pressure():
    assert ReadingUnits.COUNTS.title == "Reading (counts)"
    assert ReadingUnits.PRESSURE.title == "Pressure (kPa)"
