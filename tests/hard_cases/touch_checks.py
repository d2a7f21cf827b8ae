"""Checks of any contact with the skin, and runs that can be compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactile_maps.core.errors import SimulationError
from tactile_maps.session.frame import Failure, Frame
from tactile_maps.session.inputs import SessionInput
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session
from tests.hard_cases.touch import SPRING


@dataclass(frozen=True, eq=False)
class Run:
    """A session that ran for its full time or until it stopped with a failure.

    Attributes:
        prepared: The scene that was run.
        frames: One frame for each tick.
        failure: Reason for stopping, or None.
        session: The session in its final state.
    """

    prepared: PreparedScene
    frames: Sequence[Frame]
    failure: Failure | None
    session: Session

    @cached_property
    def forces(self) -> np.ndarray:
        """(ticks,) the sum of pressure times area [N]."""
        return np.array([frame.pressures for frame in self.frames]) @ self.prepared.skin.areas

    @cached_property
    def heights(self) -> np.ndarray:
        """(ticks, objects) [m]."""
        return np.array([frame.objects[:, 2, 3] for frame in self.frames])

    @cached_property
    def speeds(self) -> np.ndarray:
        """(ticks - 1, objects) how fast the objects rise between two ticks [m/s]."""
        return np.diff(self.heights, axis=0) / self.prepared.scene.tick

    def at(self, seconds: float) -> int:
        """Number of the frame nearest to a time."""
        return round(seconds / self.prepared.scene.tick) - 1


def play(prepared: PreparedScene, seconds: float, acts: dict[int, Sequence[SessionInput]] | None = None) -> Run:
    """Run a scene; ``acts`` are what a hand does, by the tick at which it takes effect."""
    session = Session(prepared)
    frames = []
    try:
        for tick in range(1, round(seconds / prepared.scene.tick) + 1):
            for act in (acts or {}).get(tick, ()):
                session.submit(act)
            frames.append(session.tick())
    except SimulationError:
        assert session.failure is not None, "what stops a session is kept"
    return Run(prepared, frames, session.failure, session)


def check_numbers(run: Run) -> None:
    """Everything that is shown is a number, and no taxel pulls."""
    for frame in run.frames:
        for values in (frame.posture, frame.velocity, frame.pressures, frame.objects):
            assert np.isfinite(values).all()
        assert (frame.pressures >= 0).all()
        assert len({region.id for region in frame.regions}) == len(frame.regions)


def check_repeats(run: Run, again: Run) -> None:
    """The same inputs lead to the same numbers, and stop at the same tick with the same words."""
    assert len(run.frames) == len(again.frames)
    for one, other in zip(run.frames, again.frames, strict=True):
        assert np.array_equal(one.posture, other.posture)
        assert np.array_equal(one.objects, other.objects)
        assert np.array_equal(one.pressures, other.pressures)
    assert (run.failure is None) == (again.failure is None)
    if run.failure and again.failure:
        assert (run.failure.tick, run.failure.problem) == (again.failure.tick, again.failure.problem)


def spring_force(prepared: PreparedScene, frame: Frame, *, along: tuple[float, float, float] | None = None) -> float:
    """Return the force of the motors of probes at rest at the end of their paths, by Hooke's law [N].

    ``along`` counts only the part in that direction of the world, whichever way.
    """
    ends = [np.array(thing.spec.path[-1][1:]) for thing in prepared.objects]
    stretched = [end - pose[:3, 3] for end, pose in zip(ends, frame.objects, strict=True)]
    lengths = [np.linalg.norm(s) if along is None else abs(s @ np.array(along)) for s in stretched]
    return float(SPRING * sum(lengths))


def centres(run: Run) -> np.ndarray:
    """(k, 3) centre of pressure of all taxels together at each tick at which something is felt [m], link frame."""
    forces = np.array([frame.pressures for frame in run.frames]) * run.prepared.skin.areas
    felt = forces[forces.sum(axis=1) > 0]
    return felt @ run.prepared.skin.positions / felt.sum(axis=1, keepdims=True)


def largest_jump(places: np.ndarray) -> float:
    """The longest step between places that follow each other [m]."""
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).max(initial=0.0))
