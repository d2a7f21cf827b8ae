"""Player of stimuli: inputs of scripted fingers at each tick."""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import SceneError
from tactile_maps.skin.model.skin import Skin
from tactile_maps.stimuli.skin_locations import SkinLocator
from tactile_maps.stimuli.stimulus import FingerTrack, Stimulus
from tactile_maps.tactile.poke import PokeInput, PokeMoved, PokePressed, PokeReleased

FIRST_SCRIPTED_FINGER = 0
"""Id of the first scripted finger; others count down from it. Users' fingers have ids from 1."""
_SPAN = 200
"""Ticks per lookup table entry."""


class StimulusPlayer:
    """Inputs of a script. The inputs of a tick depend on the tick alone.

    A stimulus without ``begin`` starts when the previous one in the script has ended. Others start at their time, so
    that several may be active with separate fingers. A repeated script starts again when all have ended.

    Args:
        skin: The skin.
        stimuli: The script, possibly empty.
        tick: Duration of a tick [s].
        repeat: Whether the script starts again.

    Attributes:
        ticks: Duration of the script in ticks; 0 for an empty one.
        fingers: Ids of all its fingers.

    Raises:
        SceneError: A patch of a stimulus is unknown, or a place is not on the skin; ``place`` is a key as in
            ``stimuli.0.patch``.
    """

    def __init__(self, skin: Skin, stimuli: Sequence[Stimulus], *, tick: float, repeat: bool = True) -> None:
        self._repeat = repeat
        made: list[_ScheduledTrack] = []
        self.ticks = 0
        ended = 0
        locator = SkinLocator(skin)
        lanes = _FingerIds()
        for place, stimulus in enumerate(stimuli):
            try:
                parts = [_ScheduledTrack(locator, track, tick) for track in stimulus.tracks(locator)]
            except SceneError as error:
                raise error.at(place=f"stimuli.{place}.{error.place}") from error
            period = max(part.lift for part in parts) + max(math.ceil(stimulus.rest / tick - 1e-9), 1)
            begin = ended if stimulus.begin is None else round(stimulus.begin / tick)
            for number in range(stimulus.repeat):
                ids = lanes.take(parts, begin + number * period)
                made += [part.at(begin + number * period, ids[part.finger]) for part in parts]
            ended = begin + stimulus.repeat * period
            self.ticks = max(self.ticks, ended)
        self.fingers = lanes.ids
        self._near: dict[int, list[_ScheduledTrack]] = {}
        for part in made:
            for span in range(part.press // _SPAN, part.lift // _SPAN + 1):
                self._near.setdefault(span, []).append(part)

    def inputs(self, tick: int) -> list[PokeInput]:
        """Return the inputs of tick number ``tick``, from 0. About 1 µs, and 40 µs a moving finger."""
        if not self.ticks or (tick >= self.ticks and not self._repeat):
            return []
        tick %= self.ticks
        return [act for part in self._near.get(tick // _SPAN, ()) for act in part.inputs(tick)]


class _ScheduledTrack:
    """Track in ticks: pressed at ``press``, lifted at ``lift``."""

    def __init__(self, locator: SkinLocator, track: FingerTrack, tick: float) -> None:
        self._locator = locator
        self._track = track
        self._tick = tick
        self.begin = 0
        self.id = FIRST_SCRIPTED_FINGER
        self.finger = track.finger
        self.press = round(float(track.times[0]) / tick)
        self.lift = max(math.ceil(float(track.times[-1]) / tick - 1e-9), self.press + 1)
        # The first search builds the tree, which is too slow during a run.
        self._start = locator.surface_point(*track.at(self.press * tick))
        moving = np.flatnonzero((np.diff(track.points, axis=0) != 0).any(axis=1) | (np.diff(track.patches) != 0))
        ends = track.times[[moving[0], moving[-1] + 1]] if moving.size else np.array([np.inf, -np.inf])
        self._moving = float(ends[0]), float(ends[1]) + tick

    def at(self, begin: int, number: int) -> _ScheduledTrack:
        """Return a copy that begins ``begin`` ticks later, with finger id ``number``."""
        part = copy(self)
        part.begin = begin
        part.id = number
        part.press = self.press + begin
        part.lift = self.lift + begin
        return part

    def inputs(self, tick: int) -> list[PokeInput]:
        """Return the inputs of the finger at ``tick``."""
        if not self.press <= tick <= self.lift:
            return []
        if tick == self.press:
            return [PokePressed(self.id, self._start, self._track.tip)]
        lifted = [PokeReleased(self.id)] if tick == self.lift else []
        return [*self._moves(tick), *lifted]

    def _moves(self, tick: int) -> list[PokeInput]:
        """Return the move since the previous tick; empty if the finger does not move."""
        if not self._moving[0] <= (tick - self.begin) * self._tick <= self._moving[1]:
            return []
        (patch, point), (before, there) = self._place(tick), self._place(tick - 1)
        if patch == before and np.array_equal(point, there):
            return []
        return [PokeMoved(self.id, self._locator.surface_point(patch, point))]

    def _place(self, tick: int) -> tuple[int, FloatArray]:
        return self._track.at((tick - self.begin) * self._tick)


class _FingerIds:
    """Allocation of finger ids in time: an id is free again after its lift."""

    def __init__(self) -> None:
        self._busy: list[list[tuple[int, int]]] = []

    @property
    def ids(self) -> tuple[int, ...]:
        """All allocated ids, that of the first finger first."""
        return tuple(FIRST_SCRIPTED_FINGER - lane for lane in range(len(self._busy)))

    def take(self, parts: Sequence[_ScheduledTrack], begin: int) -> dict[int, int]:
        """Allocate an id for each finger of a stimulus that begins at tick ``begin``, while its tracks last."""
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
            found[finger] = FIRST_SCRIPTED_FINGER - lane
        return found
