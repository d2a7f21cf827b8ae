"""Plays stimuli: from a script to what a scripted hand does at each tick."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from app.arrays import FloatArray
from app.simulation.poke import PokeInput, PokeMoved, PokePressed, PokeReleased
from app.simulation.stimuli.place import Ground
from app.simulation.stimuli.stimulus import Stimulus
from app.simulation.stimuli.track import Track
from app.skin.skin import Skin

FINGER = 0
"""Id of the first scripted finger; others count down from it. Hands use ids from 1."""


class StimulusPlayer:
    """Plays a script again and again. Which inputs fall on a tick depends on the tick alone.

    A stimulus without ``begin`` starts when the one before it in the script has ended; others start when they say, so
    that several may play together, each with fingers of its own. The script starts again when all have ended.

    Args:
        skin: The skin to touch.
        stimuli: None play nothing.
        tick: Seconds a tick.

    Attributes:
        ticks: In one round of the script; 0 for an empty one.
        fingers: Ids of all its fingers.

    Raises:
        SceneError: A stimulus names a place that the skin does not have.
    """

    def __init__(self, skin: Skin, stimuli: Sequence[Stimulus], *, tick: float) -> None:
        self._parts: list[_Part] = []
        self.ticks, ended, ground, lanes = 0, 0, Ground(skin), _Lanes()
        for stimulus in stimuli:
            parts = [_Part(ground, track, tick) for track in stimulus.tracks(ground)]
            period = max(part.lift for part in parts) + max(math.ceil(stimulus.rest / tick - 1e-9), 1)
            begin = ended if stimulus.begin is None else round(stimulus.begin / tick)
            for number in range(stimulus.repeat):
                ids = lanes.take(parts, begin + number * period)
                self._parts += [part.at(begin + number * period, ids[part.finger]) for part in parts]
            ended = begin + stimulus.repeat * period
            self.ticks = max(self.ticks, ended)
        self.fingers = lanes.ids
        self._presses = np.array([part.press for part in self._parts])
        self._lifts = np.array([part.lift for part in self._parts])

    def inputs(self, tick: int) -> list[PokeInput]:
        """What the scripted hand does at tick number ``tick``, from 0. About 10 µs, and 40 µs a moving finger."""
        if not self._parts:
            return []
        tick %= self.ticks
        down = np.flatnonzero((self._presses <= tick) & (tick <= self._lifts))
        return [act for number in down for act in self._parts[number].inputs(tick)]


class _Part:
    """One track in ticks: pressed at ``press``, lifted at ``lift``."""

    def __init__(self, ground: Ground, track: Track, tick: float) -> None:
        self._ground, self._track, self._tick = ground, track, tick
        self._begin, self._id, self.finger = 0, FINGER, track.finger
        self.press = round(float(track.times[0]) / tick)
        self.lift = max(math.ceil(float(track.times[-1]) / tick - 1e-9), self.press + 1)

    def at(self, begin: int, number: int) -> _Part:
        """The same ``begin`` ticks later, by finger ``number``."""
        part = _Part(self._ground, self._track, self._tick)
        part._begin, part._id = begin, number
        part.press, part.lift = self.press + begin, self.lift + begin
        return part

    def inputs(self, tick: int) -> list[PokeInput]:
        patch, point = self._place(tick)
        if tick == self.press:
            return [PokePressed(self._id, self._ground.surface_point(patch, point), self._track.tip)]
        before, there = self._place(tick - 1)
        acts: list[PokeInput] = []
        if patch != before or not np.array_equal(point, there):
            acts.append(PokeMoved(self._id, self._ground.surface_point(patch, point)))
        return [*acts, PokeReleased(self._id)] if tick == self.lift else acts

    def _place(self, tick: int) -> tuple[int, FloatArray]:
        return self._track.at((tick - self._begin) * self._tick)


class _Lanes:
    """Fingers' ids in time: an id is free again after its lift."""

    def __init__(self) -> None:
        self._busy: list[list[tuple[int, int]]] = []

    @property
    def ids(self) -> tuple[int, ...]:
        """All ids taken so far, the first finger's first."""
        return tuple(FINGER - lane for lane in range(len(self._busy)))

    def take(self, parts: Sequence[_Part], begin: int) -> dict[int, int]:
        """An id for each finger of a stimulus that begins at tick ``begin``, free while its tracks last."""
        found = {}
        for finger in sorted({part.finger for part in parts}):
            mine = [part for part in parts if part.finger == finger]
            span = begin + min(part.press for part in mine), begin + max(part.lift for part in mine)
            lane = 0
            while lane < len(self._busy) and any(a <= span[1] and span[0] <= b for a, b in self._busy[lane]):
                lane += 1
            if lane == len(self._busy):
                self._busy.append([])
            self._busy[lane].append(span)
            found[finger] = FINGER - lane
        return found
