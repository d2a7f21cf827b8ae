"""A force gain that is too much for how the skin is read is said, with what it could hold."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.loop_watch import CONTACT_STIFFNESS, LoopWatch, most_gain
from app.control.reference import INNER_FREQUENCY
from app.control.skin_readings import SkinReadings
from tests.touch import bar
from tests.unit.control.touched import touch

LEVEL = np.zeros(1)


@pytest.mark.parametrize(("delay", "limit"), [(0, 2.0), (1, 1.0), (2, 0.618), (3, 0.445), (4, 0.347)])
def test_the_most_is_that_of_a_sampled_loop(delay, limit):
    readings = SkinReadings(0.05, 0.05 * delay)
    assert 2000.0 * 0.05 * most_gain(2000.0, readings) == pytest.approx(limit, abs=5e-4)


def test_the_arm_and_what_touches_are_in_series():
    """The bar's servo at 0.3 m against a nominal contact."""
    watch, at = LoopWatch(bar()), 0.3
    watch.readings = SkinReadings(0.05)
    servo = watch._configuration.inertia()[0] * INNER_FREQUENCY**2 / at**2
    most = most_gain(1 / (1 / servo + 1 / CONTACT_STIFFNESS), watch.readings)
    (said,) = watch.look(ControlSettings("hybrid", force_gain=1.01 * most), LEVEL, touch(3.0, x=at))
    assert said == f"force gain above {most:.2g}, the most for a skin read at 20 Hz"
    assert watch.look(ControlSettings("hybrid", force_gain=0.99 * most), LEVEL, touch(3.0, x=at)) == ()


def test_it_is_said_in_contact_only_and_to_laws_that_read():
    watch, high = LoopWatch(bar()), ControlSettings("hybrid", force_gain=0.05)
    assert watch.look(high, LEVEL, touch(3.0)) == (), "nothing is known of the skin"
    watch.readings = SkinReadings(0.2, 0.2)
    assert watch.look(high, LEVEL, ()) == ()
    assert watch.look(ControlSettings("impedance", force_gain=0.05), LEVEL, touch(3.0)) == ()
    assert watch.look(high, LEVEL, touch(3.0))[0].endswith("read at 5 Hz, 200 ms late")
    watch.readings = SkinReadings(0.001)
    assert watch.look(high, LEVEL, touch(3.0)) == (), "another skin"
