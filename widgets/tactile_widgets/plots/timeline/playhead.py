"""Position of a replay as a function of elapsed time, without a clock and without Qt."""

from __future__ import annotations

from dataclasses import dataclass, replace

SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0)
"""Available speeds, as multiples of real time."""


@dataclass(frozen=True)
class Span:
    """Part of a recording.

    Attributes:
        start: Start [s from the first frame].
        end: End [s from the first frame], later than ``start``.
    """

    start: float
    end: float

    @classmethod
    def between(cls, one: float, other: float) -> Span | None:
        """Return the span between two times in any order; None if they are equal."""
        return cls(min(one, other), max(one, other)) if one != other else None

    @property
    def length(self) -> float:
        """Duration [s]."""
        return self.end - self.start


@dataclass(frozen=True)
class Playhead:
    """Position in a recording.

    Attributes:
        duration: Duration of the recording [s].
        frame_seconds: Time from one frame to the next [s], also the length of a step.
        time: Current position, within 0..duration [s].
        playing: Whether ``advanced`` moves it.
        speed: Seconds of recording per second of wall time.
        loop: Span that is repeated while the position is in it; None plays to the end.
    """

    duration: float
    frame_seconds: float = 1 / 30
    time: float = 0.0
    playing: bool = False
    speed: float = 1.0
    loop: Span | None = None

    @property
    def at_end(self) -> bool:
        """Whether the position is at the end."""
        return self.time >= self.duration

    def at(self, time: float) -> Playhead:
        """Move to ``time`` [s], clamped to the recording."""
        return replace(self, time=min(max(time, 0.0), self.duration))

    def stepped(self, frames: int) -> Playhead:
        """Move by whole frames and pause."""
        return replace(self.at(self.time + frames * self.frame_seconds), playing=False)

    def toggled(self) -> Playhead:
        """Play or pause; playing from the end starts over, and from outside the loop starts at the loop.

        An empty recording does not play.
        """
        if self.playing:
            return replace(self, playing=False)
        start = 0.0 if self.at_end else self.time
        if self.loop is not None and not self.loop.start <= start < self.loop.end:
            start = self.loop.start
        return replace(self, time=start, playing=self.duration > 0)

    def advanced(self, elapsed: float) -> Playhead:
        """Advance by ``elapsed`` wall time [s]; playing stops at the end, or continues at the start of the loop."""
        if not self.playing:
            return self
        time = self.time + elapsed * self.speed
        if (loop := self.loop) is not None and self.time <= loop.end <= time:
            return self.at(loop.start + (time - loop.end) % loop.length)
        moved = self.at(time)
        return replace(moved, playing=not moved.at_end)


def clock_text(seconds: float, *, decimals: int = 1) -> str:
    """Format as minutes and seconds, ``1:04.2``, rounded down so that a clock never shows a time not yet reached."""
    ticks = int(max(seconds, 0.0) * 10**decimals + 1e-6)
    whole, part = divmod(ticks, 10**decimals)
    text = f"{whole // 60}:{whole % 60:02d}"
    return f"{text}.{part:0{decimals}d}" if decimals else text


def nice_step(duration: float, most: int) -> float:
    """Return the smallest round distance between marks [s] that puts at most ``most`` of them into ``duration``."""
    for step in (0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800):
        if duration / step <= most:
            return float(step)
    return 3600.0 * max(1.0, -(-duration // (3600.0 * most)))
