"""Changes of settings are marked where a person's hand had come to rest."""

from __future__ import annotations

import pytest

from widgets.panels.change_marks import ChangeMarks


def marked(*events):
    """Times at which it is that time, and at which something is changed."""
    marks = ChangeMarks(seconds=10.0)
    for time, changed in events:
        marks.at(time)
        if changed:
            marks.change()
    return marks


def test_changes_age_and_are_forgotten():
    marks = marked((0.0, False), (1.0, True), (5.0, True), (6.0, False))
    assert marks.ages == (-5.0, -1.0)
    marks.at(11.5)
    assert marks.ages == (-6.5,)


def test_a_slider_on_its_way_is_one_change():
    marks = marked(*((0.1 * k, True) for k in range(30)), (4.0, False))
    assert marks.ages == pytest.approx((-1.1,))


@pytest.mark.parametrize("time", [0.0, 40.0])
def test_time_that_jumps_forgets(time):
    marks = marked((2.0, False), (3.0, True), (time, False))
    assert marks.ages == ()


def test_before_there_is_a_time_nothing_is_marked():
    marks = ChangeMarks()
    marks.change()
    assert marks.ages == ()
