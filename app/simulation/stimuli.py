"""Stimuli: a scripted hand that does what a person could do, from the same inputs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from app.arrays import FloatArray
from app.errors import SceneError
from app.geometry.closest import ClosestPoint
from app.geometry.surface_point import SurfacePoint
from app.simulation.poke import Finger, PokeInput, PokeMoved, PokePressed, PokeReleased
from app.skin.skin import Patch, Skin

FINGER = 0
"""Id of the scripted finger; hands use ids from 1."""
_STEP = 0.001
_SMOOTHING = 9


@dataclass(frozen=True)
class Stroke:
    """Press at one place, stroke to another over the skin, lift, rest. The same place twice is a poke.

    Attributes:
        patch: Name of the patch; empty for the first.
        start: Where to press: (along, around) the patch's long axis, each 0 to 1.
        end: Where to lift.
        force: The finger never pushes harder [N].
        speed: Along the skin [m/s].
        hold: Time to press in before moving [s].
        rest: Time before the next stroke [s].

    Raises:
        SceneError: A number is out of its range.
    """

    patch: str = ""
    start: tuple[float, float] = (0.25, 0.25)
    end: tuple[float, float] = (0.75, 0.25)
    force: float = 4.0
    speed: float = 0.06
    hold: float = 0.8
    rest: float = 0.6

    def __post_init__(self) -> None:
        places = [("start", value, 0.0, 1.0) for value in self.start] + [("end", value, 0.0, 1.0) for value in self.end]
        others = [("force", self.force, 0.0, 100.0), ("speed", self.speed, 1e-3, 1.0), ("hold", self.hold, 0.0, 3600.0)]
        for name, value, low, high in [*places, *others, ("rest", self.rest, 0.0, 3600.0)]:
            if not low <= value <= high:
                raise SceneError(
                    "a stroke cannot be so", place=f"strokes.{name}", value=value, remedy=f"Choose {low:g} to {high:g}"
                )


class StimulusPlayer:
    """Plays strokes one after the other, again and again. Which inputs fall on a tick depends on the tick alone.

    Args:
        skin: The skin to stroke.
        strokes: None plays nothing.
        tick: Seconds a tick.

    Raises:
        SceneError: A stroke names a patch that the skin does not have.
    """

    def __init__(self, skin: Skin, strokes: Sequence[Stroke], *, tick: float) -> None:
        self._parts = [_Part(stroke, stroke_path(skin, stroke), tick) for stroke in strokes]

    def inputs(self, tick: int) -> list[PokeInput]:
        """What the scripted hand does at tick number ``tick``."""
        if not self._parts:
            return []
        tick %= sum(part.ticks for part in self._parts)
        number = 0
        while tick >= self._parts[number].ticks:
            tick -= self._parts[number].ticks
            number += 1
        return self._parts[number].inputs(tick)


class _Part:
    """One stroke in ticks: pressed at 0, lifted at ``_lift``, at rest until ``ticks``."""

    def __init__(self, stroke: Stroke, path: list[SurfacePoint], tick: float) -> None:
        self._stroke, self._path, self._tick = stroke, path, tick
        seconds = stroke.hold + (len(path) - 1) * _STEP / stroke.speed
        self._lift = max(math.ceil(seconds / tick - 1e-9), 1)
        self.ticks = self._lift + max(math.ceil(stroke.rest / tick - 1e-9), 1)

    def inputs(self, tick: int) -> list[PokeInput]:
        if tick == 0:
            return [PokePressed(FINGER, self._path[0], Finger(max_force=self._stroke.force))]
        if tick > self._lift:
            return []
        last, now, before = len(self._path) - 1, self._place(tick), self._place(tick - 1)
        if tick == self._lift:
            return [PokeMoved(FINGER, self._path[last]), PokeReleased(FINGER)]
        return [PokeMoved(FINGER, self._path[now])] if now > before else []

    def _place(self, tick: int) -> int:
        along = max(tick * self._tick - self._stroke.hold, 0.0) * self._stroke.speed / _STEP
        return min(int(along), len(self._path) - 1)


def stroke_path(skin: Skin, stroke: Stroke) -> list[SurfacePoint]:
    """Places 1 mm apart along a stroke: the shortest way through neighbouring taxels, smoothed, laid on the surface.

    Where no way leads from start to end, since the patch's taxels stand in groups, it is the end alone.

    Raises:
        SceneError: No such patch.
    """
    names = [patch.name for patch in skin.patches]
    if stroke.patch and stroke.patch not in names:
        raise SceneError(
            "there is no such patch to stroke",
            place="stroke",
            value=stroke.patch,
            remedy=f"Choose one of: {', '.join(names)}",
        )
    number = names.index(stroke.patch) if stroke.patch else 0
    patch = skin.patches[number]
    ends = [_taxel_at(patch, place) for place in (stroke.start, stroke.end)]
    line = _evenly(patch.taxels.positions[_taxels_between(patch, *ends)])
    faces, weights, _ = ClosestPoint(patch.surface).query(line)
    return [
        SurfacePoint(number, int(face), (float(a), float(b), float(c)))
        for face, (a, b, c) in zip(faces, weights, strict=True)
    ]


def _taxel_at(patch: Patch, place: tuple[float, float]) -> int:
    """The taxel nearest to fractions (along, around) of the patch's extents about its long axis."""
    centred = patch.taxels.positions - patch.taxels.positions.mean(axis=0)
    axes = np.linalg.svd(centred, full_matrices=False)[2]
    # The sign of a singular vector is chance: fix it by its largest component.
    axes *= np.sign(axes[np.arange(3), np.abs(axes).argmax(axis=1)])[:, None]
    along = centred @ axes[0]
    around = np.arctan2(centred @ axes[2], centred @ axes[1]) / (2 * np.pi)
    miss = (along - along.min()) / max(float(np.ptp(along)), 1e-12) - place[0]
    turn = (around - place[1] + 0.5) % 1.0 - 0.5
    return int(np.argmin(miss**2 + turn**2))


def _taxels_between(patch: Patch, first: int, last: int) -> list[int]:
    pairs, positions = patch.taxels.neighbours, patch.taxels.positions
    lengths = np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1)
    graph = coo_matrix((lengths, (pairs[:, 0], pairs[:, 1])), shape=(len(positions),) * 2).tocsr()
    _, before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)
    path = [last]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return path[::-1]


def _evenly(line: FloatArray) -> FloatArray:
    """Points ``_STEP`` apart along a polyline, its corners rounded by a running mean."""
    steps = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    places = np.arange(0.0, steps[-1] + _STEP, _STEP)
    even = np.stack([np.interp(places, steps, line[:, k]) for k in range(3)], axis=1)
    width = min(_SMOOTHING, (len(even) - 1) // 2)
    for _ in range(3):
        total = np.cumsum(np.pad(even, ((width + 1, width), (0, 0)), mode="edge"), axis=0)
        even = (total[2 * width + 1 :] - total[: -2 * width - 1]) / (2 * width + 1)
    return even
