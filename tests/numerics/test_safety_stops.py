"""Safety stops of the simulated arm: what stops it, and how it moves afterwards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.task_control.monitors import STOP_SPEED, YIELD_SPEED
from app.session.runtime_settings import RuntimeSettings
from app.session.session import Session
from app.tactile.poke import Finger, PokePressed
from tests.support.touch import arm

TAXEL = 150


def velocities_after_stop(controller: str, *, gravity: str) -> np.ndarray:
    """Return the joint velocities (k, n) of an arm that a finger has stopped and presses for 3 s."""
    effects = replace(RuntimeSettings.of_scene(arm()).effects, gravity=gravity)
    session = Session(
        arm(), scripted=False, settings=ControlSettings(controller=controller, stiffness=40.0), effects=effects
    )
    session.submit(PokePressed(1, arm().skin.taxel_point(TAXEL), Finger(speed=2.0, max_force=200.0)))
    velocities, stopped = [], False
    for _ in range(600):
        frame = session.tick()
        stopped = stopped or any(limit.kind.stops for limit in frame.why_limited)
        if stopped:
            velocities.append(frame.velocity)
    assert stopped
    return np.array(velocities)


@pytest.mark.parametrize("controller", ["impedance", "hold_force", "hybrid"])
@pytest.mark.parametrize("gravity", ["compensated", "on"])
def test_stopped_arm_gives_way_to_gravity_and_a_finger_at_a_bounded_speed(controller, gravity):
    """A finger of 200 N moves the arm at up to 2.3 rad/s where only the soft impedance holds it."""
    velocities = velocities_after_stop(controller, gravity=gravity)
    assert np.abs(velocities).max() < STOP_SPEED / 2
    assert np.abs(velocities).max() > 0.25 * YIELD_SPEED, "it does give way"
