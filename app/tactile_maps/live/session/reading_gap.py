"""Gaps in the readings of a real skin, and problems of its packets: for how long they last, and why."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from math import isinf

from tactile_maps.live.session.connection import SILENT_SECONDS, ConnectionState, ConnectionStatus
from tactile_maps.live.session.facts import MeasuredFacts

_RECENT = 5.0
"""Time for which a rejected packet counts as a current problem although readings are used again [s]."""


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
        return f"No readings for {_length_text(self.seconds)}"


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


def _length_text(seconds: float) -> str:
    """Return a length of time in whole hours, minutes or seconds."""
    minutes = int(seconds) // 60
    hours = minutes // 60
    return f"{hours}\u202fh" if hours else f"{minutes}\u202fmin" if minutes else f"{int(seconds)}\u202fs"


@dataclass(frozen=True)
class PacketProblem:
    """A reason for which packets were rejected.

    Attributes:
        text: Error of the newest packet that was rejected for it.
        seconds: Time since this packet [s].
        over: Whether readings have been used since.
    """

    text: str
    seconds: float
    over: bool

    @property
    def age(self) -> str:
        """Time since the newest rejected packet, in words that change once a minute."""
        return "less than 1\u202fmin ago" if self.seconds < 60 else f"{_length_text(self.seconds)} ago"


class ProblemWatch:
    """Finds out which problems of the packets are over. Mutable: it stores the newest counts and their times."""

    def __init__(self) -> None:
        self._newest: dict[str, tuple[int, float, int]] = {}  # rejected packets, time of the newest, readings by then

    def find(self, status: ConnectionStatus, facts: MeasuredFacts, now: float) -> tuple[PacketProblem, ...]:
        """Return the problems of the packets so far, readings that do not fit the skin first."""
        problems = []
        found = {"refused": (facts.refused, facts.problem), "malformed": (status.counts.malformed, status.malformed)}
        for kind, (count, text) in found.items():
            if not text:
                continue
            if kind not in self._newest or self._newest[kind][0] != count:
                self._newest[kind] = count, now, facts.readings
            _, at, readings = self._newest[kind]
            over = now - at >= _RECENT and facts.readings > readings
            problems.append(PacketProblem(text, now - at, over))
        return tuple(problems)
