"""Conditions on the readings while motion is sent; the first violated one is reported.

Motion depends on every taxel of the skin and every joint of the robot: a taxel without data could be touched, and a
joint without data could have any position. The time at which each was measured is the arrival of its reading minus the
reading's age on arrival (``data_age``). None may be older than ``OLDEST_SECONDS``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.errors import names_text
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.live.motion.motion_sender import OLDEST_SECONDS, StopReason
from tactile_maps.live.readings.data_age import DataAge
from tactile_maps.live.session.facts import tare_doubt
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.live.session.skin_readings import MOST_PRESSURE

_RECENT = f"a reading newer than {OLDEST_SECONDS:g} s"
LEAST_PRESSURE = -1e5
"""Lowest plausible calibrated pressure [Pa]: suction is limited by atmospheric pressure."""


@dataclass(frozen=True)
class InputProblem:
    """A reason not to send motion.

    Attributes:
        reason: Reason to stop.
        detail: Names and figures.
        awaited: What is awaited before sending, without figures that change; None if sending ends instead.
    """

    reason: StopReason
    detail: str
    awaited: str | None


class InputMonitor:
    """Checks the readings of a session. Mutable.

    Args:
        session: Session that uses the readings.
        ages: Ages of the readings of its connection.
    """

    def __init__(self, session: MeasuredSession, ages: DataAge) -> None:
        self._session = session
        self._ages = ages
        self.reset()

    def reset(self, *, accepted: str | None = "") -> None:
        """Disregard earlier events.

        Args:
            accepted: Doubt about the tare that the user has accepted, see ``tare_doubt``; None to accept any.
        """
        self._accepted = accepted
        self._implausible = self._session.implausible.count
        self._jumps = self._ages.jumps
        self._implausible_at = -np.inf

    @property
    def measured(self) -> float:
        """Time of the oldest current value or position, by the receiver's clock [s]; -inf if one is unknown."""
        heard = self._session.heard
        return float(min(heard.taxels.min(initial=np.inf), heard.joints.min(initial=np.inf)))

    def check(self, now: float, *, starting: bool) -> InputProblem | None:
        """Return why motion must not be sent; None if it may. Cost: 20 µs.

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
            return InputProblem(StopReason.CLOCK, "or the sender was restarted", "readings of a steady clock")
        if old := self.old(now):
            return old
        if impossible := self._impossible_pressure():
            return InputProblem(StopReason.IMPLAUSIBLE, impossible, "pressures that are possible")
        if heard.frozen.any():
            return InputProblem(StopReason.FROZEN, heard.frozen_text(), "values that change")
        facts = session.facts
        if facts.taring:
            return InputProblem(StopReason.UNKNOWN, "the skin is being tared", "the end of the tare")
        doubt = tare_doubt(facts)
        if doubt and self._accepted not in (doubt, None):
            return InputProblem(StopReason.DOUBTFUL_TARE, doubt.removesuffix("."), None)
        if starting and not self._ages.settled:
            return InputProblem(StopReason.CLOCK, "", "readings that arrive evenly")
        return None

    def _impossible_pressure(self) -> str:
        """Return the first pressure of the newest frame that is out of range after calibration, in words; empty for
        none.
        """
        frame = self._session.frame
        skin = self._session.prepared.skin
        if frame.units is not ReadingUnits.CALIBRATED:
            return ""
        possible = (frame.pressures >= LEAST_PRESSURE) & (frame.pressures <= MOST_PRESSURE)
        if possible.all():
            return ""
        taxel = int((~possible).argmax())
        limits = f"From {LEAST_PRESSURE:g} to {MOST_PRESSURE:g} Pa"
        return f"{skin.taxel_text(taxel)}: {frame.pressures[taxel]:g} Pa after calibration. {limits}"

    def old(self, now: float) -> InputProblem | None:
        """Return which readings are missing or too old; None if none are. Thread-safe."""
        heard = self._session.heard
        session = self._session
        if heard.arrived == -np.inf:
            awaited = "a reading that fits the skin" if session.facts.refused else "the first reading"
            return InputProblem(StopReason.STALE, "none came", awaited)
        silent = now - heard.arrived
        if silent > OLDEST_SECONDS:
            return InputProblem(StopReason.STALE, f"none for {silent:.2f} s", _RECENT)
        if not self.measured >= now - OLDEST_SECONDS:
            return self._too_old(now)
        return None

    def _too_old(self, now: float) -> InputProblem:
        """Return what is too old: all readings, or some joints and taxels."""
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
        return InputProblem(StopReason.NOT_HEARD, f"{names_text(names)}: {since}", names_text(names))
