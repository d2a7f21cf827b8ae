"""Where a replay stands, without a clock and without Qt: elapsed time comes in, the position comes out."""

from __future__ import annotations

from dataclasses import dataclass, replace

SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0)
"""The speeds on offer, as multiples of real time."""


@dataclass(frozen=True)
class Span:
    """A part of a recording.

    Attributes:
        start: Seconds from its first frame.
        end: The same; later than ``start``.
    """

    start: float
    end: float

    @classmethod
    def between(cls, one: float, other: float) -> Span | None:
        """From the earlier to the later; None where they are the same moment."""
        return cls(min(one, other), max(one, other)) if one != other else None

    @property
    def length(self) -> float:
        """Seconds."""
        return self.end - self.start


@dataclass(frozen=True)
class Playhead:
    """A position in a recording.

    Attributes:
        duration: Of the recording [s].
        frame_seconds: Time from one frame to the next [s]; what one step is.
        time: Where it stands, within 0..duration [s].
        playing: Whether ``advanced`` moves it.
        speed: Seconds of recording per second of watching.
        loop: What is played again and again while it is in there; None plays to the end.
    """

    duration: float
    frame_seconds: float = 1 / 30
    time: float = 0.0
    playing: bool = False
    speed: float = 1.0
    loop: Span | None = None

    @property
    def at_end(self) -> bool:
        """Whether there is nothing left to play."""
        return self.time >= self.duration

    def at(self, time: float) -> Playhead:
        """Stand at ``time`` [s]; beyond either end means that end."""
        return replace(self, time=min(max(time, 0.0), self.duration))

    def stepped(self, frames: int) -> Playhead:
        """Move by whole frames and pause: who steps wants to look."""
        return replace(self.at(self.time + frames * self.frame_seconds), playing=False)

    def toggled(self) -> Playhead:
        """Play or pause; playing from the end starts over, in a loop from its start if it stands beside it.

        An empty recording does not play.
        """
        if self.playing:
            return replace(self, playing=False)
        start = 0.0 if self.at_end else self.time
        if self.loop is not None and not self.loop.start <= start < self.loop.end:
            start = self.loop.start
        return replace(self, time=start, playing=self.duration > 0)

    def advanced(self, elapsed: float) -> Playhead:
        """Let ``elapsed`` wall time [s] pass; playing stops at the end, and goes round in a loop."""
        if not self.playing:
            return self
        time = self.time + elapsed * self.speed
        if (loop := self.loop) is not None and self.time <= loop.end <= time:
            return self.at(loop.start + (time - loop.end) % loop.length)
        moved = self.at(time)
        return replace(moved, playing=not moved.at_end)


def clock_text(seconds: float, *, decimals: int = 1) -> str:
    """Minutes and seconds for a person: ``1:04.2``. Rounds down, so that a clock never shows what is not reached."""
    ticks = int(max(seconds, 0.0) * 10**decimals + 1e-6)
    whole, part = divmod(ticks, 10**decimals)
    text = f"{whole // 60}:{whole % 60:02d}"
    return f"{text}.{part:0{decimals}d}" if decimals else text


def nice_step(duration: float, most: int) -> float:
    """The smallest round distance between marks [s] that puts at most ``most`` of them into ``duration``."""
    for step in (0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800):
        if duration / step <= most:
            return float(step)
    return 3600.0 * max(1.0, -(-duration // (3600.0 * most)))
