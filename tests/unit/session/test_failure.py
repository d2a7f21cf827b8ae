"""Why a session stopped, as a value."""

from __future__ import annotations

from app.errors import SimulationError
from app.session.failure import Failure
from app.session.session import Session
from tests.touch import prepared_bar


def test_it_says_what_a_person_read():
    error = SimulationError("the simulation diverged", place="joint hinge at 0.1 s", remedy="Reset")
    failure = Failure(21, error, (), Session(prepared_bar()).frame)
    assert failure.problem == "joint hinge at 0.1 s: the simulation diverged. Reset."
