"""Gaps in the readings of a real skin: for how long no reading has been used, and why."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from math import isinf

from tactile_maps.live.session.connection import SILENT_SECONDS, ConnectionState, ConnectionStatus
from tactile_maps.live.session.facts import MeasuredFacts


class GapCause(StrEnum):
    """Cause of a gap, as the end of a sentence."""

    SILENT = "none arrive"
    REJECTED = "all packets are rejected"
    BROKEN = "the source is not open"


@dataclass(frozen=True)
class ReadingGap:
    """A gap in the readings that has not ended.

    Attributes:
        cause: Cause of the gap.
        seconds: Time since the newest used reading [s]; infinite before the first.
        reason: Error of the source or of the newest rejected packet; empty if none is known.
    """

    cause: GapCause
    seconds: float
    reason: str = ""

    @property
    def words(self) -> str:
        """The length of the gap, such as ``No readings for 3 s``."""
        if isinf(self.seconds):
            return "No readings yet"
        minutes = int(self.seconds) // 60
        hours = minutes // 60
        length = f"{hours}\u202fh" if hours else f"{minutes}\u202fmin" if minutes else f"{int(self.seconds)}\u202fs"
        return f"No readings for {length}"


class GapWatch:
    """Finds the gaps in the readings of one connection. Mutable: it stores the counts at the newest used reading."""

    def __init__(self) -> None:
        self._used = 0
        self._malformed = 0
        self._refused = 0

    def find(self, status: ConnectionStatus, facts: MeasuredFacts, seconds: float) -> ReadingGap | None:
        """Return the current gap; None while readings are used.

        Args:
            status: Status of the connection.
            facts: Facts about its readings.
            seconds: Time since the newest used reading [s]; infinite before the first.
        """
        malformed = status.counts.malformed
        if facts.readings != self._used:
            self._used = facts.readings
            self._malformed = malformed
            self._refused = facts.refused
        state = status.state
        if state in (ConnectionState.RECONNECTING, ConnectionState.FAILED):
            return ReadingGap(GapCause.BROKEN, seconds, status.problem or "")
        if state is ConnectionState.ENDED and facts.readings:
            return None
        if seconds >= SILENT_SECONDS:
            if malformed > self._malformed and state is not ConnectionState.RECEIVING:
                return ReadingGap(GapCause.REJECTED, seconds, status.malformed or "")
            if facts.refused > self._refused:
                return ReadingGap(GapCause.REJECTED, seconds, facts.problem or "")
        silent = state in (ConnectionState.WAITING, ConnectionState.CLOSED)
        return ReadingGap(GapCause.SILENT, seconds) if silent else None
