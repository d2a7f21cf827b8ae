"""What a tick answers: a frame, one frozen instant of a session and all that a view or a recorder may know.

Where the physics gives up there is a ``Failure`` instead, with all that is needed to see it happen again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import takewhile

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.events import ContactEvent
from tactile_maps.contacts.force_estimation.estimate import ForceEstimate
from tactile_maps.control.motion.command import JointCommand, TaskReport
from tactile_maps.control.motion.limits import Limit
from tactile_maps.core.arrays import FloatArray, freeze_arrays
from tactile_maps.core.errors import SimulationError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.core.timing import Timings
from tactile_maps.session.inputs import SessionInput
from tactile_maps.session.measured_values import MeasuredValues
from tactile_maps.tactile.mechanics.contact_notes import ContactNote
from tactile_maps.tactile.poke import PokeState


@dataclass(frozen=True, eq=False)
class Frame:
    """One instant.

    Attributes:
        tick: Number of control ticks since the start.
        time: Simulated time [s].
        posture: (n,) joint positions.
        velocity: (n,) joint velocities.
        pressures: (taxels,) [Pa]; of a real skin what ``units`` says.
        regions: Contact regions read from the map.
        pokes: Fingers on the skin.
        command: What the controller asked for at this tick.
        why_limited: What bounds the controller now, one of each kind; empty when nothing does.
        timings: Wall milliseconds by stage of this tick; never part of a comparison.
        objects: (k, 4, 4) pose ``T_world_object`` of each of the scene's objects, in its order.
        notes: What physics and the skin's model could not do as asked at this tick; empty when nothing.
        recent: The newest contact events up to this tick, newest first: a view that shows only some of the frames
            misses none.
        task: How the controller's task goes; None under a controller without one.
        estimates: What the force estimator in force answered, by region; empty with the area sum. A region whose
            estimate refused has the area sum.
        measured: What a real skin sent; None where it is simulated.

    Example:
        >>> frame = session.tick()
        >>> frame.pressures.shape, frame.posture.shape
        ((60,), (7,))
    """

    tick: int
    time: float
    posture: FloatArray
    velocity: FloatArray
    pressures: FloatArray
    regions: tuple[ContactRegion, ...]
    pokes: tuple[PokeState, ...]
    command: JointCommand
    why_limited: tuple[Limit, ...] = ()
    timings: Timings = field(default_factory=Timings)
    objects: FloatArray = field(default_factory=lambda: np.zeros((0, 4, 4)))
    notes: tuple[ContactNote, ...] = ()
    recent: tuple[ContactEvent, ...] = ()
    task: TaskReport | None = None
    estimates: Mapping[int, ForceEstimate] = field(default_factory=dict)
    measured: MeasuredValues | None = None

    def __post_init__(self) -> None:
        freeze_arrays(self, "posture", "velocity", "pressures", "objects")

    @property
    def units(self) -> ReadingUnits:
        """What its pressures and forces may be called."""
        return ReadingUnits.CALIBRATED if self.measured is None else self.measured.units

    @property
    def events(self) -> tuple[ContactEvent, ...]:
        """What contacts began or ended to do at this very tick, in the order in which it was noticed."""
        return tuple(takewhile(lambda event: event.tick == self.tick, self.recent))[::-1]


@dataclass(frozen=True, eq=False)
class Failure:
    """A tick that could not be finished: the physics left the numbers that mean something.

    Attributes:
        tick: The one that was not finished.
        error: What was wrong, where and when.
        inputs: (tick, input) since the reset, those of ``tick`` included; with the scene they repeat the failure.
        frame: The last good one, of the tick before.
    """

    tick: int
    error: SimulationError
    inputs: tuple[tuple[int, SessionInput], ...]
    frame: Frame

    @property
    def problem(self) -> str:
        """The message, for people; replays compare the error itself."""
        return str(self.error)
