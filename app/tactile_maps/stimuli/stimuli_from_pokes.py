"""Stimuli from recorded pokes: each press, motion and lift becomes one stimulus that repeats it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.geometry.surface.points import cumulative_lengths
from tactile_maps.skin.model.skin import Skin
from tactile_maps.stimuli.skin_locations import SkinLocator
from tactile_maps.stimuli.stimulus import FingerTrack, Stimulus
from tactile_maps.stimuli.stimulus_kinds import FingerPath, Poke, Stroke
from tactile_maps.stimuli.stimulus_player import FIRST_SCRIPTED_FINGER
from tactile_maps.tactile.poke import Finger, PokeInput, PokeMoved, PokePressed, PokePulled, PokeReleased

TOLERANCE = 0.0005
"""Largest distance of a stimulus from the recorded places [m]."""
_REACH = 0.02
_DIGITS = 5


def stimuli_from_pokes(
    skin: Skin, inputs: Sequence[tuple[int, object]], *, tick: float, last: int | None = None, scripted: bool = False
) -> tuple[Stimulus, ...]:
    """Return stimuli that repeat recorded pokes; times are relative to the first press.

    Args:
        skin: The skin that was touched.
        inputs: (tick, input) in order, as a session stores them; other inputs than pokes are ignored.
        tick: Duration of a tick [s].
        last: Tick at which fingers that are still down are lifted; None is just after the last input.
        scripted: Whether pokes of a script are included.

    Returns:
        One stimulus per press: a poke if the finger did not move, a stroke if it moved straight at constant speed,
        otherwise a path. Each is within ``TOLERANCE`` of the recorded places at their ticks, with the same finger.
    """
    pokes = [
        (at, act) for at, act in inputs if isinstance(act, PokeInput) and (scripted or act.id > FIRST_SCRIPTED_FINGER)
    ]
    touches = _touches(pokes, last)
    if not touches:
        return ()
    locator = SkinLocator(skin)
    first = min(touch.ticks[0] for touch in touches)
    return tuple(_stimulus(locator, touch, tick, first) for touch in sorted(touches, key=lambda touch: touch.ticks[0]))


@dataclass
class _Touch:
    """A finger from press to lift: its places with their ticks, and the tick of the lift."""

    finger: Finger
    ticks: list[int]
    places: list[SurfacePoint]
    lift: int

    def move(self, tick: int, at: SurfacePoint) -> None:
        """Move to ``at``; the last of several places in one tick counts."""
        if self.ticks[-1] == tick and len(self.ticks) > 1:
            self.places[-1] = at
        else:
            self.ticks.append(max(tick, self.ticks[-1] + 1))
            self.places.append(at)


def _touches(inputs: Sequence[tuple[int, PokeInput]], last: int | None) -> list[_Touch]:
    """Return all touches; pressing a finger that is down lifts it first, moving one that is up has no effect."""
    end = max((tick for tick, _ in inputs), default=0) + 1 if last is None else last
    down: dict[int, _Touch] = {}
    touches: list[_Touch] = []
    for tick, act in inputs:
        if isinstance(act, PokePressed | PokeReleased) and act.id in down:
            down.pop(act.id).lift = tick
        if isinstance(act, PokePressed):
            down[act.id] = _Touch(act.finger, [tick], [act.at], lift=end)
            touches.append(down[act.id])
        elif isinstance(act, PokeMoved | PokePulled) and act.id in down:
            down[act.id].move(tick, act.at)
    for touch in touches:
        touch.lift = max(touch.lift, touch.ticks[-1], touch.ticks[0] + 1)
    return touches


def _stimulus(locator: SkinLocator, touch: _Touch, tick: float, first: int) -> Stimulus:
    """Return the simplest kind that is within the tolerance."""
    track = _track(locator, touch, tick)
    begin = round((touch.ticks[0] - first) * tick, 9)
    for candidate in (_poke(locator, track, begin), _stroke(locator, track, begin)):
        if candidate is not None and _within_tolerance(candidate.tracks(locator)[0], track):
            return candidate
    return _path(locator, track, begin)


def _track(locator: SkinLocator, touch: _Touch, tick: float) -> FingerTrack:
    """Return the track of a touch, lifted at its last place. A pause before a move ends just before the move."""
    times = [(at - touch.ticks[0]) * tick for at in touch.ticks]
    rows = [(times[0], touch.places[0])]
    for time, before, at in zip(times[1:], touch.places, touch.places[1:], strict=False):
        if time - rows[-1][0] > 2 * _REACH:
            rows.append((time - _REACH, before))
        rows.append((time, at))
    lift = (touch.lift - touch.ticks[0]) * tick
    if lift > rows[-1][0]:
        rows.append((lift, rows[-1][1]))
    return FingerTrack(
        0,
        touch.finger,
        np.array([time for time, _ in rows]),
        np.array([at.patch for _, at in rows]),
        np.array([locator.skin.position(at) for _, at in rows]),
    )


class _Common(TypedDict):
    """Arguments that all kinds have in common."""

    force: float
    press: float
    radius: float
    stiffness: float
    begin: float


def _finger(track: FingerTrack, begin: float) -> _Common:
    tip = track.tip
    return {
        "force": tip.max_force,
        "press": tip.speed,
        "radius": tip.radius,
        "stiffness": tip.stiffness,
        "begin": begin,
    }


def _poke(locator: SkinLocator, track: FingerTrack, begin: float) -> Stimulus | None:
    """Return a poke at the place of the press."""
    patch = locator.skin.patches[int(track.patches[0])].name
    hold = round(float(track.times[-1]), 9)
    return Poke(patch=patch, at=_place(track.points[0]), hold=hold, **_finger(track, begin))


def _stroke(locator: SkinLocator, track: FingerTrack, begin: float) -> Stimulus | None:
    """Return a stroke over one patch from press to lift at the mean speed; None if it is not one."""
    moving = np.flatnonzero((np.diff(track.points, axis=0) != 0).any(axis=1))
    if not moving.size or np.ptp(track.patches):
        return None
    patch = int(track.patches[0])
    start = _place(track.points[0])
    end = _place(track.points[-1])
    leave = float(track.times[moving[0]])
    arrive = float(track.times[moving[-1] + 1])
    length = float(cumulative_lengths(locator.surface_path(patch, start, end))[-1])
    low, high = next((low, high) for name, low, high in Stroke.ranges if name == "speed")
    if not low <= length / (arrive - leave) <= high:
        return None
    return Stroke(
        patch=locator.skin.patches[patch].name,
        start=start,
        end=end,
        hold=round(leave, 9),
        speed=length / (arrive - leave),
        stay=round(float(track.times[-1]) - arrive, 9),
        **_finger(track, begin),
    )


def _path(locator: SkinLocator, track: FingerTrack, begin: float) -> Stimulus:
    """Return a path through as few of the places as possible."""
    kept = _simplified(track)
    names = tuple(locator.skin.patches[int(track.patches[k])].name for k in kept)
    points = tuple((round(float(track.times[k]), 9), *_place(track.points[k])) for k in kept)
    several = names if len(set(names)) > 1 else ()
    return FingerPath(patch=names[0], points=points, patches=several, **_finger(track, begin))


def _simplified(track: FingerTrack) -> list[int]:
    """Return the places that linear interpolation in time requires (algorithm of Ramer, Douglas and Peucker)."""
    kept = {0, len(track.times) - 1}
    waiting = [(0, len(track.times) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        patches = track.patches[first : last + 1]
        times = track.times[first : last + 1]
        share = (times - times[0]) / (times[-1] - times[0])
        # A finger waits before it changes to another patch, whose places are in another frame.
        along = track.points[last] - track.points[first] if patches[0] == patches[-1] else np.zeros(3)
        away = np.linalg.norm(track.points[first : last + 1] - track.points[first] - share[:, None] * along, axis=1)
        away[patches != patches[0]] = np.inf
        away[[0, -1]] = -1.0
        worst = int(np.argmax(away))
        if away[worst] > TOLERANCE:
            kept.add(first + worst)
            waiting += [(first, first + worst), (first + worst, last)]
    return sorted(kept)


def _within_tolerance(said: FingerTrack, track: FingerTrack) -> bool:
    """Whether a track is within ``TOLERANCE`` of all recorded places at their times."""
    places = [said.at(float(time)) for time in track.times]
    return all(patch == int(k) for (patch, _), k in zip(places, track.patches, strict=True)) and all(
        np.linalg.norm(point - recorded) <= TOLERANCE for (_, point), recorded in zip(places, track.points, strict=True)
    )


def _place(point: FloatArray) -> tuple[float, float, float]:
    """Round a point to a hundredth of a millimetre, for a script."""
    x, y, z = (round(float(value), _DIGITS) for value in point)
    return x, y, z
