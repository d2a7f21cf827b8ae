"""Whatever is set and whatever the skin reads, a law asks for something finite and bounded, and repeats itself."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from app.control.command import ControlSettings
from app.control.contact_motion import ContactMotionController
from app.control.reference import MAX_LEAD
from app.control.settings_check import CHOICES, RANGES
from tests.touch import arm
from tests.unit.control.touched import TICK, touch_on

PREPARED = arm()
NUMBERS = {name: st.floats(low, min(high, 1e6)) for name, (low, high) in RANGES.items()}
PATHS = st.lists(st.tuples(st.floats(-0.5, 1.5), st.floats(-0.5, 1.5)), max_size=4).map(tuple)
SETTINGS = st.builds(
    ControlSettings, **NUMBERS, **{name: st.sampled_from(known) for name, known in CHOICES.items()}, path=PATHS
)
CONTACT = st.tuples(st.integers(0, len(PREPARED.skin) - 1), st.floats(0.0, 300.0) | st.just(float("nan")))
TICKS = st.lists(st.lists(CONTACT, max_size=3), min_size=1, max_size=12)


def run(first, second, ticks):
    controller = ContactMotionController(PREPARED.robot, first, PREPARED.map)
    posture, velocity, commands = PREPARED.robot.home, np.zeros(7), []
    for tick, contacts in enumerate(ticks):
        regions = tuple(touch_on(PREPARED.map, taxel, force, id_=k + 1) for k, (taxel, force) in enumerate(contacts))
        command = controller.command(posture, velocity, regions, TICK)
        commands.append((posture, command))
        posture = posture + 0.5 * (command.posture - posture)
        if tick == len(ticks) // 2:
            controller.settings = second
    return commands, controller.why_limited


@settings(max_examples=150, deadline=None)
@given(SETTINGS, SETTINGS, TICKS)
def test_commands_are_finite_bounded_and_the_same_again(first, second, ticks):
    commands, why = run(first, second, ticks)
    again, _ = run(first, second, ticks)
    for (posture, command), (_, same) in zip(commands, again, strict=True):
        assert np.isfinite(command.torque_at(posture, np.zeros(7))).all()
        assert np.array_equal(command.posture, same.posture)
        if "impedance" not in (first.law, second.law):
            assert np.abs(command.posture - posture).max() <= MAX_LEAD + 1e-9
    assert all(why)
