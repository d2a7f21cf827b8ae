"""A reading is checked at birth."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.live.readings.readings import MalformedReadingError, Reading, Unit, unit_of


def test_units_convert_to_pascals():
    assert [unit.pascals for unit in Unit] == [None, 1.0, 1000.0]
    assert unit_of("kPa") is Unit.KILOPASCAL
    with pytest.raises(MalformedReadingError, match="counts, Pa, kPa"):
        unit_of("psi")


@pytest.mark.parametrize(
    ("parts", "place"),
    [
        ({"ids": [1, 2]}, "ids"),
        ({"channels": [1, 2, 3]}, "channels"),
        ({"values": [1.0, np.nan, -np.inf]}, "values, 2"),
        ({"values": [[1.0]]}, "values"),
        ({"time": np.inf}, "time"),
        ({"joints": {"elbow": np.nan}}, "elbow"),
    ],
)
def test_invalid_value_is_rejected_by_name(parts, place):
    with pytest.raises(MalformedReadingError) as caught:
        Reading(**{"time": 0.0, "values": [1.0, 2.0, 3.0]} | parts)
    assert caught.value.place == place


def test_arrays_of_a_reading_are_read_only():
    reading = Reading(0.0, np.arange(3.0), ids=[3, 1, 2])
    with pytest.raises(ValueError, match="read-only"):
        reading.values[0] = 1.0
    assert reading.ids.dtype == np.int64
