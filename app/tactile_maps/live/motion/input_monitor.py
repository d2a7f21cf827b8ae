"""Everything that must hold of the readings while motion is sent; the first thing that does not is named.

Motion depends on every taxel of the skin and every joint of the robot: what is not heard could touch or be anywhere.
Each of them has the time at which it was measured, which is the arrival of its reading less the age that the reading
had then (``data_age``). None may be older than ``OLDEST_SECONDS``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.live.channels.last_heard import named
from tactile_maps.live.motion.motion_sender import OLDEST_SECONDS, StopReason
from tactile_maps.live.readings.data_age import DataAge
from tactile_maps.live.session.measured_session import MOST_PRESSURE, MeasuredSession

_RECENT = f"a reading newer than {OLDEST_SECONDS:g} s"
LEAST_PRESSURE = -1e5
"""Least plausible pressure after calibration [Pa]: nothing pulls by more than the pressure of the air."""


@dataclass(frozen=True)
class InputProblem:
    """A reason not to send motion.

    Attributes:
        reason: Why sending stops.
        detail: Names and figures to it.
        awaited: What is waited for before sending, without figures that change.
    """

    reason: StopReason
    detail: str
    awaited: str


class InputMonitor:
    """Checks the readings of a session. Mutable.

    Args:
        session: That readings are taken into.
        ages: Of its connection.
    """

    def __init__(self, session: MeasuredSession, ages: DataAge) -> None:
        self._session = session
        self._ages = ages
        self.reset()

    def reset(self) -> None:
        """Disregard what happened so far."""
        self._implausible = self._session.implausible.count
        self._jumps = self._ages.jumps
        self._implausible_at = -np.inf

    @property
    def measured(self) -> float:
        """Time of the oldest value or position that is current, by the receiver's clock [s]; -inf if one is unknown."""
        heard = self._session.heard
        return float(min(heard.taxels.min(initial=np.inf), heard.joints.min(initial=np.inf)))

    def check(self, now: float, *, starting: bool) -> InputProblem | None:
        """Return why motion must not be sent; None where it may. Cost: 20 µs.

        Args:
            now: Receiver's clock [s].
            starting: True before motion is sent: the ages must have settled first.
        """
        heard = self._session.heard
        session = self._session
        if session.implausible.count > self._implausible:
            self._implausible = session.implausible.count
            self._implausible_at = now
        if now - self._implausible_at <= OLDEST_SECONDS:
            return InputProblem(StopReason.IMPLAUSIBLE, session.implausible.text, "readings that are possible")
        if self._ages.jumps > self._jumps:
            self._jumps = self._ages.jumps
            return InputProblem(StopReason.CLOCK, "or the sender was started again", "readings of a steady clock")
        if old := self.old(now):
            return old
        if impossible := self._impossible_pressure():
            return InputProblem(StopReason.IMPLAUSIBLE, impossible, "pressures that are possible")
        if heard.frozen.any():
            return InputProblem(StopReason.FROZEN, heard.frozen_text(), "values that change")
        if session.facts.taring:
            return InputProblem(StopReason.UNKNOWN, "the skin is being tared", "the end of the tare")
        if starting and not self._ages.settled:
            return InputProblem(StopReason.CLOCK, "", "readings that arrive evenly")
        return None

    def _impossible_pressure(self) -> str:
        """Return which pressure of the newest frame is out of range after calibration; empty for none."""
        frame = self._session.frame
        skin = self._session.prepared.skin
        if frame.units is not ReadingUnits.CALIBRATED:
            return ""
        possible = (frame.pressures >= LEAST_PRESSURE) & (frame.pressures <= MOST_PRESSURE)
        if possible.all():
            return ""
        taxel = int((~possible).argmax())
        name = str(skin.taxel_name(taxel)) or f"taxel {taxel}"
        limits = f"From {LEAST_PRESSURE:g} to {MOST_PRESSURE:g} Pa"
        return f"{name}: {frame.pressures[taxel]:g} Pa by the calibration. {limits}"

    def old(self, now: float) -> InputProblem | None:
        """Return which readings are missing or too old; None where none is. Any thread may call it."""
        heard = self._session.heard
        session = self._session
        if heard.arrived == -np.inf:
            awaited = "a reading that fits the skin" if session.facts.refused else "the first reading"
            return InputProblem(StopReason.STALE, "none came", awaited)
        silent = now - heard.arrived
        if silent > OLDEST_SECONDS:
            return InputProblem(
                StopReason.STALE, f"none for {silent:.2f} s", f"a reading newer than {OLDEST_SECONDS:g} s"
            )
        if not self.measured >= now - OLDEST_SECONDS:
            return self._too_old(now)
        return None

    def _too_old(self, now: float) -> InputProblem:
        """What is too old: all readings, or some joints and taxels."""
        heard = self._session.heard
        joints = self._session.prepared.robot.joints
        oldest = now - OLDEST_SECONDS
        newest = max(heard.taxels.max(initial=-np.inf), heard.joints.max(initial=-np.inf))
        if newest < oldest:
            return InputProblem(StopReason.BACKLOG, f"the newest is {now - newest:.2f} s old", "newer readings")
        names = [f"joint {joints[number].name}" for number in np.flatnonzero(~(heard.joints >= oldest)).tolist()]
        names += heard.taxel_names(~(heard.taxels >= oldest))
        age = now - self.measured
        since = f"not heard for {age:.2f} s" if np.isfinite(age) else "not heard yet"
        return InputProblem(StopReason.NOT_HEARD, f"{named(names)}: {since}", named(names))
