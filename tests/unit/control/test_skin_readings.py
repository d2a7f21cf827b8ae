"""What is known of a skin's readings, and how a law may take one that stands at its end."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.control.skin_readings import SkinReadings, at_least
from tests.unit.control.touched import touch


@pytest.mark.parametrize(
    ("readings", "words"),
    [(SkinReadings(0.05), "read at 20 Hz"), (SkinReadings(0.001, 0.005), "read at 1e+03 Hz, 5 ms late")],
)
def test_it_says_so_in_words(readings, words):
    assert str(readings) == words


def test_a_reading_at_its_end_is_no_less_than_the_goal():
    (weak,), (strong,) = touch(1.0), touch(2.0, id_=2)
    end = replace(weak, peak=180e3)
    taken, plateau = at_least((strong, end), 3.0, 180e3)
    assert plateau
    assert [(region.id, region.force) for region in taken] == [(1, 3.0), (2, 2.0)], "the strongest first"
    assert at_least((replace(end, force=5.0),), 3.0, 180e3)[0][0].force == 5.0
    assert at_least((strong, weak), 3.0, 180e3) == ((strong, weak), False)
    assert at_least((), 3.0, 180e3) == ((), False)
