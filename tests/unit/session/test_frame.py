"""Frames and failures as values; a failure repeats."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings, JointCommand
from tactile_maps.core.errors import SimulationError
from tactile_maps.session.frame import Failure, Frame
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import Finger, PokePressed
from tests.support.touch import prepared_bar


def test_it_owns_its_arrays():
    none = np.zeros(0)
    pressures = np.zeros(3)
    frame = Frame(1, 0.005, none, none, pressures, (), (), JointCommand(none, none, none, none))
    pressures[0] = 1
    assert frame.pressures[0] == 0
    assert not frame.posture.flags.writeable
    assert frame.timings.total_ms == 0
    assert frame.why_limited == frame.notes == ()
    assert frame.objects.shape == (0, 4, 4)


UNSTEADY = prepared_bar(tick=0.2, overrides={"integrator": "euler", "timestep": 0.02})
"""With stiff, strongly damped joints: explicit damping of that strength swings up (``too_stiff``) within one control
tick, before a monitor of the speed can stop it."""


def test_it_says_what_a_person_read():
    error = SimulationError("the simulation diverged", place="joint hinge at 0.1 s", remedy="Reset")
    failure = Failure(21, error, (), Session(UNSTEADY).frame)
    assert failure.problem == "joint hinge at 0.1 s: the simulation diverged. Reset."


def too_stiff() -> Session:
    """A session that diverges as soon as the finger touches, five ticks after its start."""
    session = Session(UNSTEADY, settings=ControlSettings(stiffness=40.0, damping_ratio=3.0))
    for _ in range(5):
        session.tick()
    session.submit(PokePressed(1, UNSTEADY.skin.taxel_point(30), Finger(stiffness=10.0)))
    return session


def until_it_stops(session) -> None:
    for _ in range(400):
        session.tick()


def test_a_session_that_diverges_says_all_that_is_needed_to_see_it_again():
    session = too_stiff()
    with pytest.raises(SimulationError, match="diverged") as first:
        until_it_stops(session)
    failure = session.failure
    assert failure is not None
    assert failure.problem == str(first.value)
    assert failure.frame is session.frame
    assert failure.tick == session.frame.tick + 1
    assert np.isfinite(failure.frame.posture).all()
    assert [type(act).__name__ for _, act in failure.inputs] == ["ControlChanged", "PokePressed"]
    with pytest.raises(SimulationError, match="diverged"):
        session.tick()
    assert session.frame.tick == failure.tick - 1, "it stays where it stopped"
    again = too_stiff()
    with pytest.raises(SimulationError):
        until_it_stops(again)
    assert (again.failure.tick, again.failure.problem) == (failure.tick, failure.problem)
    session.reset()
    assert session.failure is None
    assert session.tick().tick == 1
