"""Result of a tick: a frozen ``Frame`` with everything that views and recordings show of one instant.

A tick that fails produces a ``Failure`` instead, which contains what is needed to reproduce it.
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
from tactile_maps.core.arrays import ArrayFields, FloatArray
from tactile_maps.core.errors import TactileMapsError, counted
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.core.timing import Timings
from tactile_maps.session.inputs import SessionInput
from tactile_maps.tactile.mechanics.contact_notes import ContactNote
from tactile_maps.tactile.poke import PokeState


@dataclass(frozen=True, eq=False)
class MeasuredValues(ArrayFields):
    """Values of a real skin at one frame, as sent.

    Attributes:
        raw: (taxels,) newest value of each taxel, before offset, baseline and gain; NaN before the first one.
        unit: Unit of ``raw``: ``counts``, ``Pa`` or ``kPa``.
        sent: Time on the sender's clock [s]; None before the first reading.
        sequence: Running number of the packet; None if the sender does not number them.
        units: Units in which the frame's pressures may be stated.
        raw_shear: (taxels, 2) newest values along t1 and t2 of each taxel, like ``raw``; None if none was sent.
    """

    raw: FloatArray
    unit: str
    sent: float | None
    sequence: int | None
    units: ReadingUnits
    raw_shear: FloatArray | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Frame(ArrayFields):
    """State of a session at one instant.

    Attributes:
        tick: Number of control ticks since the start.
        time: Simulated time [s].
        posture: (n,) joint positions.
        velocity: (n,) joint velocities.
        pressures: (taxels,) [Pa]; of a real skin in the unit of ``units``.
        regions: Contact regions read from the map.
        pokes: Fingers on the skin.
        command: Command of the controller at this tick.
        why_limited: Current limits of the controller, one of each kind.
        timings: Wall milliseconds by stage of this tick; not part of comparisons.
        objects: (k, 4, 4) pose ``T_world_object`` of each of the scene's objects, in its order.
        notes: Requests that the physics and the model of the skin could not fulfil at this tick.
        recent: The newest contact events up to this tick, newest first, so that a view that shows only some of the
            frames misses none.
        task: Progress of the controller's task; None for a controller without tasks.
        estimates: Results of the current force estimator by region; empty with the area sum. A region whose estimate
            was rejected has the area sum.
        measured: Values of a real skin; None for a simulated one.
        shear: (taxels, 2) traction of the touching bodies on each taxel along its axes t1 and t2, as ``pressures``
            states the one against n [Pa]; None where it is neither simulated nor measured.

    Example:
        >>> frame = session.tick()
        >>> frame.pressures.shape, frame.posture.shape
        ((60,), (7,))
        >>> frame
        Frame(tick 21, 0.105 s, 7 joints, 60 taxels up to 0 kPa, no contact)
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
    shear: FloatArray | None = None

    def __repr__(self) -> str:
        """Summary in one line: the arrays of a large skin would fill pages."""
        units = self.units
        words = [f"{one.link} {units.contact_words(one.force, one.peak, 2, space=' ')}" for one in self.regions]
        found = f"{counted(len(words), 'contact')}: {', '.join(words[:3])}" if words else "no contact"
        more = ", ..." * (len(words) > 3)
        noted = f", {counted(len(self.notes), 'note')}" if self.notes else ""
        peak = f"{1e-3 * float(self.pressures.max(initial=0.0)):.3g} {units.unit}"
        joints = counted(len(self.posture), "joint")
        skin = f"{counted(len(self.pressures), 'taxel')} up to {peak}"
        return f"Frame(tick {self.tick}, {self.time:.6g} s, {joints}, {skin}, {found}{more}{noted})"

    @property
    def units(self) -> ReadingUnits:
        """Units in which its pressures and forces may be stated."""
        return ReadingUnits.CALIBRATED if self.measured is None else self.measured.units

    @property
    def strongest_force(self) -> float:
        """Largest force of a contact [N]; 0 without contacts."""
        return max((region.force for region in self.regions), default=0.0)

    @property
    def highest_pressure(self) -> float:
        """Largest pressure, at least 0; taxels without a value do not count."""
        return float(np.nanmax(self.pressures, initial=0.0))

    @property
    def events(self) -> tuple[ContactEvent, ...]:
        """Contact events of this tick, in the order in which they were detected."""
        return tuple(takewhile(lambda event: event.tick == self.tick, self.recent))[::-1]


@dataclass(frozen=True, eq=False)
class Failure:
    """A tick that could not be completed, because the physics diverged or a plug-in failed.

    Attributes:
        tick: The tick that was not completed.
        error: The error, with its place and time.
        inputs: (tick, input) since the reset, up to and including ``tick``; with the scene they reproduce the failure.
        frame: The last valid frame, of the previous tick.
    """

    tick: int
    error: TactileMapsError
    inputs: tuple[tuple[int, SessionInput], ...]
    frame: Frame

    @property
    def problem(self) -> str:
        """The message for the user; replays compare the error itself."""
        return str(self.error)
