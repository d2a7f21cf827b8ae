"""Kinds of stimuli, each a value that returns the tracks of its fingers.

- ``Poke``: press at one place, hold, lift.
- ``Tap``: short pokes at one place, one after the other.
- ``Stroke``: press at one place, move to another over the skin, lift.
- ``Roll``: a fingertip that rolls over the skin to and fro at constant force.
- ``FingerPath``: a finger at given points and times, such as recorded ones.
- ``Grasp``: fingers around a link, which press against each other.
- ``Babble``: pokes and strokes at random places, seeded.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import SceneError
from tactile_maps.geometry.surface.points import cumulative_lengths, points_along
from tactile_maps.geometry.surface.raycast import RayCaster
from tactile_maps.skin.model.skin import Skin
from tactile_maps.stimuli.skin_locations import SkinLocation, SkinLocator, principal_axes
from tactile_maps.stimuli.stimulus import FingerTrack, Stimulus, stationary_track
from tactile_maps.tactile.babbling import KINDS, BabbleSpec, Kind, taxel_pitch, touched_places


@dataclass(frozen=True, kw_only=True)
class Poke(Stimulus):
    """Press at one place, hold, lift.

    Attributes:
        at: Place.
        hold: Time from press to lift [s].
    """

    kind = "poke"
    places = ("at",)
    ranges = (("hold", 0.0, 3600.0),)

    at: SkinLocation = (0.5, 0.25)
    hold: float = 1.0

    def tracks(self, locator: SkinLocator) -> tuple[FingerTrack, ...]:
        patch = locator.patch(self.patch)
        return (stationary_track(0, self.tip, patch, locator.point(patch, self.at), press=0.0, lift=self.hold),)


@dataclass(frozen=True, kw_only=True)
class Tap(Stimulus):
    """Short, quick pokes at one place.

    Attributes:
        at: Place.
        taps: Number of taps.
        down: Time from each press to its lift [s].
        up: Time from each lift to the next press [s].
    """

    kind = "tap"
    places = ("at",)
    ranges = (("taps", 1, 10_000), ("down", 0.001, 3600.0), ("up", 0.001, 3600.0))

    at: SkinLocation = (0.5, 0.25)
    taps: int = 5
    down: float = 0.08
    up: float = 0.12
    press: float = 0.1

    def tracks(self, locator: SkinLocator) -> tuple[FingerTrack, ...]:
        patch = locator.patch(self.patch)
        each = self.down + self.up
        point = locator.point(patch, self.at)
        return tuple(
            stationary_track(0, self.tip, patch, point, press=number * each, lift=number * each + self.down)
            for number in range(self.taps)
        )


@dataclass(frozen=True, kw_only=True)
class Stroke(Stimulus):
    """Press at one place, move to another along ``SkinLocator.surface_path`` at constant speed, lift.

    Attributes:
        start: Place of the press.
        end: Place of the lift.
        speed: Speed along the skin [m/s].
        hold: Time to press in before moving [s].
        stay: Time at the end before the lift [s].
    """

    kind = "stroke"
    places = ("start", "end")
    ranges = (("speed", 1e-3, 10.0), ("hold", 0.0, 3600.0), ("stay", 0.0, 3600.0))

    start: SkinLocation = (0.25, 0.25)
    end: SkinLocation = (0.75, 0.25)
    speed: float = 0.06
    hold: float = 0.8
    stay: float = 0.0

    def tracks(self, locator: SkinLocator) -> tuple[FingerTrack, ...]:
        patch = locator.patch(self.patch)
        line = locator.surface_path(patch, self.start, self.end)
        times = self.hold + cumulative_lengths(line) / self.speed
        times = np.concatenate([[0.0], times, [times[-1] + self.stay]])
        return (
            FingerTrack(0, self.tip, times, np.full(len(times), patch), np.concatenate([line[:1], line, line[-1:]])),
        )


_SAMPLES_PER_ROLL = 48


@dataclass(frozen=True, kw_only=True)
class Roll(Stimulus):
    """Press, roll the fingertip to one side, to the other, and back, a number of times, lift.

    A ball that rolls without slipping moves its contact as far over the skin as over itself: ``radius`` times the
    rolled angle. The contact moves about ``at`` as a sine of that amplitude, at the force reached in ``hold``.

    Attributes:
        at: Centre of the motion.
        heading: Direction of the first roll, about the outward normal from the patch's long axis [deg].
        angle: Rolled angle to each side [deg].
        rolls: Number of rolls to and fro.
        seconds: Duration of each [s].
        hold: Time to press in before rolling [s].
    """

    kind = "roll"
    places = ("at",)
    ranges = (
        ("heading", -360.0, 360.0),
        ("angle", 0.0, 180.0),
        ("rolls", 1, 10_000),
        ("seconds", 0.02, 3600.0),
        ("hold", 0.0, 3600.0),
    )

    at: SkinLocation = (0.5, 0.25)
    heading: float = 0.0
    angle: float = 60.0
    rolls: int = 2
    seconds: float = 1.5
    hold: float = 0.8

    def tracks(self, locator: SkinLocator) -> tuple[FingerTrack, ...]:
        patch = locator.patch(self.patch)
        middle = locator.point(patch, self.at)
        width = self.radius * np.deg2rad(self.angle)
        heading = self._heading(locator, patch, middle)
        sides = [locator.straight_path(patch, middle, middle + sign * width * heading) for sign in (-1.0, 1.0)]
        line = np.concatenate([sides[0][:0:-1], sides[1]])
        turns = np.linspace(0.0, self.rolls, self.rolls * _SAMPLES_PER_ROLL + 1)
        # The middle is where the two sides meet; on a curved skin they are not quite as long as the tangent.
        place = cumulative_lengths(line) - cumulative_lengths(sides[0])[-1]
        sway = width * np.sin(2 * np.pi * turns)
        points = points_along(line, place, sway)
        times = np.concatenate([[0.0], self.hold + self.seconds * turns])
        points = np.concatenate([points[:1], points])
        return (FingerTrack(0, self.tip, times, np.full(len(times), patch), points),)

    def _heading(self, locator: SkinLocator, patch: int, point: FloatArray) -> FloatArray:
        """Return a unit vector (3,) along the skin at ``point``, link frame."""
        normal = locator.skin.normal(locator.surface_point(patch, point))
        axes = principal_axes(locator.skin.patches[patch])
        # The long axis may be normal to the skin, as on a cap; the next one is tangential then.
        along = axes[0] if abs(axes[0] @ normal) < 0.9 else axes[1]
        along = along - (along @ normal) * normal
        along /= np.linalg.norm(along)
        turn = np.deg2rad(self.heading)
        return np.asarray(np.cos(turn) * along + np.sin(turn) * np.cross(normal, along))


TimedPoints: TypeAlias = tuple[tuple[float, float, float, float], ...]
"""(seconds, x, y, z): time [s] and position in the frame of the patch's link [m]."""


@dataclass(frozen=True, kw_only=True)
class FingerPath(Stimulus):
    """Press at the first point, move linearly between points at the given times, lift at the last.

    Attributes:
        points: At least two, from 0 seconds on, each later than the one before.
        patches: Name of each point's patch if there are several; empty if all are on ``patch``.
    """

    kind = "path"

    points: TimedPoints
    patches: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        times = [point[0] for point in self.points]
        if len(times) < 2 or times[0] != 0.0 or not all(0 < b - a < 3600.0 for a, b in pairwise(times)):
            remedy = "Write at least two [seconds, x, y, z], from 0 seconds on, each later than the one before"
            raise self.refusal("points", times, remedy)
        if self.patches and len(self.patches) != len(self.points):
            remedy = f"Name one for each of the {len(self.points)} points, or none"
            raise self.refusal("patches", list(self.patches), remedy)
        for point in self.points:
            self.check_place("points", point[1:])

    def tracks(self, locator: SkinLocator) -> tuple[FingerTrack, ...]:
        if self.patches:
            patches = [locator.patch(name, key=f"patches.{k}") for k, name in enumerate(self.patches)]
        else:
            patches = [locator.patch(self.patch)] * len(self.points)
        places = enumerate(zip(patches, self.points, strict=True))
        points = [locator.point(patch, point[1:], key=f"points.{k}") for k, (patch, point) in places]
        times = np.array([point[0] for point in self.points])
        return (FingerTrack(0, self.tip, times, np.array(patches), np.array(points)),)


_MIN_DEPTH = 1e-3


@dataclass(frozen=True, kw_only=True)
class Grasp(Stimulus):
    """Several fingers press at once from around a link, hold, lift together.

    The fingers are in the section perpendicular to the patch's long axis through ``at``, evenly around its centre, the
    first one at ``at``. Each presses the outermost skin of the link there, on any patch.

    Attributes:
        at: Place of the first finger.
        fingers: Number of fingers.
        hold: Time from press to lift [s].
    """

    kind = "grasp"
    places = ("at",)
    ranges = (("fingers", 2, 20), ("hold", 0.0, 3600.0))

    at: SkinLocation = (0.5, 0.25)
    fingers: int = 3
    hold: float = 1.5

    def tracks(self, locator: SkinLocator) -> tuple[FingerTrack, ...]:
        patch = locator.patch(self.patch)
        first = locator.point(patch, self.at)
        axis = principal_axes(locator.skin.patches[patch])[0]
        middle = _section_middle(locator, patch, first, axis)
        places = [
            (patch, first),
            *(self._opposing(locator, patch, first, middle, axis, n) for n in range(1, self.fingers)),
        ]
        return tuple(stationary_track(n, self.tip, *place, press=0.0, lift=self.hold) for n, place in enumerate(places))

    def _opposing(
        self, locator: SkinLocator, patch: int, first: FloatArray, middle: FloatArray, axis: FloatArray, number: int
    ) -> tuple[int, FloatArray]:
        """Return patch and point (3,) of another finger: the first hit of a ray towards the centre."""
        turn = 2 * np.pi * number / self.fingers
        out = first - middle
        out = np.cos(turn) * out + np.sin(turn) * np.cross(axis, out)
        out /= np.linalg.norm(out)
        patches = locator.skin.patches
        link = locator.skin.patches[patch].link
        far = max(other.surface.size for other in patches if other.link == link)
        best: tuple[float, int, FloatArray] | None = None
        for index, other in enumerate(patches):
            hit = RayCaster(other.surface).first_hit(middle + far * out, -out) if other.link == link else None
            # Beyond the centre is the other side, which another finger presses.
            if hit is not None and hit.distance < far and (best is None or hit.distance < best[0]):
                best = hit.distance, index, other.surface.point(hit.face, hit.weights)
        if best is None:
            raise self.refusal(
                "fingers", self.fingers, f"Finger {number + 1} finds no skin on its side of {link}; grasp elsewhere"
            )
        return best[1], best[2]


def _section_middle(locator: SkinLocator, patch: int, first: FloatArray, axis: FloatArray) -> FloatArray:
    """Return the centre (3,) of the link's skin in the plane normal to ``axis`` through ``first``, link frame [m]."""
    crossings = [first[None]]
    for other in locator.skin.patches:
        if other.link == locator.skin.patches[patch].link:
            ends = other.surface.vertices[other.surface.edges]
            height = (ends - first) @ axis
            cut = (height[:, 0] < 0) != (height[:, 1] < 0)
            share = height[cut, 0] / (height[cut, 0] - height[cut, 1])
            crossings.append(ends[cut, 0] + share[:, None] * (ends[cut, 1] - ends[cut, 0]))
    points = np.concatenate(crossings)
    # The middle of the bounds does not depend on the density of triangles.
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    normal = locator.skin.normal(locator.surface_point(patch, first))
    inward = np.asarray((normal @ axis) * axis - normal)
    # The centre of a flat skin would be on the skin.
    return middle if (middle - first) @ inward > _MIN_DEPTH else first + _MIN_DEPTH * inward


_SAMPLE_SPACING = 0.7
"""Spacing of places of a random stroke in pitches; see ``tactile_maps.tactile.babbling``."""


@dataclass(frozen=True, kw_only=True)
class Babble(Stimulus):
    """Random pokes and short strokes, uniform by area, at the places of ``babbling``.

    Attributes:
        patch: Name of the patch; empty for the whole skin.
        way: Simultaneous places: one (``unbiased``), two of different patches (``self-touch``), three
            (``multi-touch``), or one, but two distant places always together (``biased``).
        touches: Number of touches.
        strokes: Share of the touches that are strokes.
        length: Smallest length of a stroke [m].
        speed: Speed of a stroke along the skin [m/s].
        hold: Time to press in [s]; a poke ends then.
        pause: Time between two touches [s].
        force: Mean force; each touch has 0.5 to 1.5 times as much [N].
        seed: Seed of places, strokes and forces.
    """

    kind = "babble"
    ranges = (
        ("touches", 1, 10_000),
        ("strokes", 0.0, 1.0),
        ("length", 0.0, 1.0),
        ("speed", 1e-3, 10.0),
        ("hold", 0.001, 3600.0),
        ("pause", 0.001, 3600.0),
        ("seed", 0, 2**31),
    )

    way: Kind = "unbiased"
    touches: int = 20
    strokes: float = 0.5
    length: float = 0.04
    speed: float = 0.06
    hold: float = 0.5
    pause: float = 0.2
    force: float = 3.0
    press: float = 0.03
    seed: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.way not in KINDS:
            raise self.refusal("way", self.way, f"Choose one of: {', '.join(KINDS)}")

    def tracks(self, locator: SkinLocator) -> tuple[FingerTrack, ...]:
        first, skin = self._skin(locator)
        samples = math.ceil(self.length / (_SAMPLE_SPACING * taxel_pitch(skin))) + 1
        spec = BabbleSpec(self.way, self.touches, samples, seed=self.seed)
        places = touched_places(skin, spec)
        # A separate stream, so that the number of strokes does not change the places.
        generator = np.random.default_rng([self.seed, 1])
        forces = generator.uniform(0.5, 1.5, self.touches)
        moves = generator.random(self.touches) < self.strokes
        found = []
        begin = 0.0
        for touch in range(self.touches):
            tip = replace(self.tip, max_force=self.force * float(forces[touch]))
            end = begin + self.hold
            for finger in np.flatnonzero(places.pressed[touch, 0]).tolist():
                patch = first + int(places.patches[touch, 0, finger])
                line = locator.project(patch, places.positions[touch, : samples if moves[touch] else 1, finger])
                times = begin + self.hold + cumulative_lengths(line) / self.speed
                times = np.concatenate([[begin], times])
                line = np.concatenate([line[:1], line])
                found.append(FingerTrack(finger, tip, times, np.full(len(times), patch), line))
                end = max(end, float(times[-1]))
            begin = end + self.pause
        return tuple(found)

    def _skin(self, locator: SkinLocator) -> tuple[int, Skin]:
        """Return the index of the first touched patch, and the touched skin."""
        if not len(locator.skin):
            raise SceneError("the skin has no taxels to touch", place="patch", remedy="Cover at least one link")
        if not self.patch:
            return 0, locator.skin
        first = locator.patch(self.patch)
        return first, Skin(locator.skin.patches[first : first + 1])
