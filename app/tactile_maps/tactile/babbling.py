"""Babbling: a skin is touched at random, and what its taxels read is written down, for maps to be learned from.

Quasi-static: no arm moves. Each touch is a ball pressed on the skin, felt through the same pressure model as in a
simulation, so that the statistics are those of this skin's taxels: which of them feel the same contact, and how much.
A touch may also be a short stroke, so that time is in the readings.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, assert_never

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist, squareform

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, freeze_arrays
from tactile_maps.core.errors import SimulationError
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load, sphere_load
from tactile_maps.tactile.models.water_fill import WaterFillModel

Kind = Literal["unbiased", "self-touch", "multi-touch", "biased"]
KINDS: tuple[Kind, ...] = ("unbiased", "self-touch", "multi-touch", "biased")
_BALL = 4.0
_FOOTPRINT = 2.0
_BIASED_REGION = 3.0
_STEP = 0.7
_MANY = 3


@dataclass(frozen=True)
class BabbleSpec:
    """How a skin is touched to learn from. Lengths "in pitches" are in spacings of the skin's own taxels.

    Attributes:
        kind: ``unbiased``: one place at a time, all equally likely by area. ``self-touch``: two places of different
            patches press each other with the same force (on a skin of one patch, any two). ``multi-touch``: three
            places at a time. ``biased``: as unbiased, but two far places are always pressed together: what
            co-activation cannot tell from being neighbours.
        touches: How many, at least 1.
        samples: Readings in each touch: 1 is a poke; more are a stroke over the skin, 0.7 pitches a sample.
        rest: Readings with nothing on the skin after each touch, so that one stroke does not run into the next.
        radius: Of the ball [m]; None is 4 pitches.
        force: Mean force [N], each touch from half to one and a half of it; None makes a footprint of 2 pitches radius.
        noise: Standard deviation of each reading, as a share of the mean pressure in the middle of a touch.
        together: The two taxels in the middle of the places that ``biased`` presses together; None are the two
            farthest apart on the patch with the most taxels.
        seed: Chooses places, forces, ways and noise.

    Raises:
        SimulationError: A number is out of its range.
    """

    kind: Kind = "unbiased"
    touches: int = 3000
    samples: int = 1
    rest: int = 0
    radius: float | None = None
    force: float | None = None
    noise: float = 0.02
    together: tuple[int, int] | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise SimulationError(
                "there is no such kind of babbling", value=self.kind, remedy=f"Choose one of: {', '.join(KINDS)}"
            )
        ranges = [
            ("touches", self.touches, 1, 10_000_000),
            ("samples", self.samples, 1, 10_000),
            ("rest", self.rest, 0, 10_000),
            ("radius", 0.01 if self.radius is None else self.radius, 1e-4, 10.0),
            ("force", 1.0 if self.force is None else self.force, 1e-6, 1e6),
            ("noise", self.noise, 0.0, 10.0),
        ]
        for name, value, low, high in ranges:
            if not low <= value <= high:
                remedy = f"Choose {low:g} to {high:g}"
                raise SimulationError(
                    "the babbling setting is out of range", place=f"babbling.{name}", value=value, remedy=remedy
                )


def babble(skin: Skin, spec: BabbleSpec) -> FloatArray:
    """Touch ``skin`` as ``spec`` says; the same spec gives the same readings, bit for bit.

    Args:
        skin: At least one taxel.
        spec: How.

    Returns:
        (touches * (samples + rest), taxels) pressure [Pa], in the order of time. Noise makes some readings negative,
        as those of a sensor whose rest is zero.

    Raises:
        SimulationError: The skin has no taxels, or not the ones to be pressed together.

    Cost: 0.4 to 0.8 s for 3000 pokes on 250 to 1000 taxels; more where more quadrature points lie under the ball.
    """
    if not len(skin):
        raise SimulationError("the skin has no taxels for babbling", remedy="Cover at least one link")
    generator = np.random.default_rng(spec.seed)
    ground = _TouchableSites(skin)
    if spec.together is not None and not all(0 <= taxel < len(skin) for taxel in spec.together):
        remedy = f"Choose two of 0 to {len(skin) - 1}"
        raise SimulationError("there are no such taxels to press together", value=spec.together, remedy=remedy)
    ways = _ways(ground, spec, generator)
    radius = _BALL * ground.pitch if spec.radius is None else spec.radius
    force = _footprint_force(_FOOTPRINT * ground.pitch, radius) if spec.force is None else spec.force
    forces = force * generator.uniform(0.5, 1.5, spec.touches)
    readings = np.zeros((spec.touches, spec.samples + spec.rest, len(skin)))
    model = WaterFillModel(skin)
    for touch in range(spec.touches):
        for sample in range(spec.samples):
            places = ways.sites[touch, sample][ways.pressed[touch, sample]]
            readings[touch, sample] = model.pressures([ground.load(p, forces[touch], radius) for p in places])
    middle = readings[:, : spec.samples].max(axis=2).mean()
    readings += generator.normal(scale=spec.noise * middle, size=readings.shape)
    return readings.reshape(-1, len(skin))


@dataclass(frozen=True, eq=False)
class TouchedPlaces:
    """Where a skin is touched.

    Attributes:
        positions: (touches, samples, at once, 3) [m], link frames.
        patches: (touches, samples, at once) the patch of each.
        pressed: (touches, samples, at once) whether it is touched; where not, place and patch mean nothing.
    """

    positions: FloatArray
    patches: IntArray
    pressed: BoolArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "positions")
        freeze_arrays(self, "patches", dtype=np.int64)
        freeze_arrays(self, "pressed", dtype=bool)


def touched_places(skin: Skin, spec: BabbleSpec) -> TouchedPlaces:
    """Where ``babble`` would touch, for a finger to touch there: the same places for the same spec.

    Args:
        skin: At least one taxel.
        spec: How; only kind, touches, samples, together and seed count.
    """
    ground = _TouchableSites(skin)
    ways = _ways(ground, spec, np.random.default_rng(spec.seed))
    return TouchedPlaces(ground.positions[ways.sites], ground.patch[ways.sites], ways.pressed)


def taxel_pitch(skin: Skin) -> float:
    """Spacing of a skin's taxels [m], as if they stood in a hexagonal lattice."""
    return float(np.sqrt(np.median(skin.areas) * 2 / np.sqrt(3)))


def _footprint_force(contact: float, ball: float) -> float:
    """Force [N] with which a ball makes a footprint of that radius on a flat bed of springs: pi K a^4 / (4 R)."""
    return np.pi * ElasticLayer().foundation * contact**4 / (4 * ball)


class _TouchableSites:
    """All places of a skin that can be touched: its quadrature points, numbered through the patches."""

    def __init__(self, skin: Skin) -> None:
        points = [patch.taxels.quadrature for patch in skin.patches]
        self._skin = skin
        starts = skin.first[:-1]
        self.positions = np.concatenate([q.positions for q in points])
        self.normals = np.concatenate([q.normals for q in points])
        areas = np.concatenate([q.areas for q in points])
        self._shares = areas / areas.sum()
        self.patch = np.repeat(np.arange(len(points)), [len(q.areas) for q in points])
        self._taxel = np.concatenate([q.taxel + start for q, start in zip(points, starts, strict=True)])
        self.pitch = taxel_pitch(skin)
        self._trees = [cKDTree(q.positions) for q in points]
        self._first = np.cumsum([0, *(len(q.areas) for q in points)])

    def load(self, place: int, force: float, radius: float) -> Load:
        link = self._skin.patches[self.patch[place]].link
        return sphere_load(link, self.positions[place], self.normals[place], force, radius)

    def anywhere(self, count: int, generator: np.random.Generator) -> IntArray:
        """(count,) places, equally likely by area."""
        return generator.choice(len(self._shares), count, p=self._shares)

    def middle_of(self, taxel: int) -> int:
        """The place nearest to the middle of a taxel's area."""
        own = np.flatnonzero(self._taxel == taxel)
        return int(own[np.linalg.norm(self.positions[own] - self.positions[own].mean(axis=0), axis=1).argmin()])

    def farthest_taxels(self) -> tuple[int, int]:
        """The two taxels farthest apart on the patch with the most taxels."""
        counts = np.diff(self._skin.first)
        patch = int(counts.argmax())
        apart = squareform(pdist(self._skin.patches[patch].taxels.positions))
        a, b = np.unravel_index(apart.argmax(), apart.shape)
        start = int(self._skin.first[patch])
        return start + int(a), start + int(b)

    def nearest(self, points: FloatArray, patch: IntArray) -> IntArray:
        """(k,) the place of each point's patch (k,) nearest to it (k, 3)."""
        found = np.empty(len(points), dtype=np.int64)
        for number in np.unique(patch):
            here = patch == number
            found[here] = self._first[number] + self._trees[number].query(points[here])[1]
        return found


@dataclass(frozen=True, eq=False)
class _Ways:
    """(touches, samples, at once) sites of ``_TouchableSites``, and which of them are pressed."""

    sites: IntArray
    pressed: BoolArray


def _ways(ground: _TouchableSites, spec: BabbleSpec, generator: np.random.Generator) -> _Ways:
    """Which places each touch presses."""
    match spec.kind:
        case "unbiased" | "biased":
            start = ground.anywhere(spec.touches, generator)[:, None]
        case "multi-touch":
            start = ground.anywhere(_MANY * spec.touches, generator).reshape(-1, _MANY)
        case "self-touch":
            start = _pairs(ground, spec.touches, generator)
        case _:
            assert_never(spec.kind)
    way = [start.ravel()]
    heading = generator.normal(size=(start.size, 3))
    for _ in range(spec.samples - 1):
        place, heading = _onwards(ground, way[-1], heading, generator)
        way.append(place)
    ways = np.stack(way).reshape(spec.samples, *start.shape).transpose(1, 0, 2)
    if spec.kind == "biased":
        return _with_partners(ground, ways, spec.together)
    return _Ways(ways, np.ones(ways.shape, dtype=np.bool_))


def _pairs(ground: _TouchableSites, count: int, generator: np.random.Generator) -> IntArray:
    """(count, 2) places of two different patches, if there are; the first equally likely by area, so is the second."""
    pairs = ground.anywhere(2 * count, generator).reshape(count, 2)
    several = len(np.unique(ground.patch)) > 1
    while several and (same := np.flatnonzero(ground.patch[pairs[:, 0]] == ground.patch[pairs[:, 1]])).size:
        pairs[same, 1] = ground.anywhere(len(same), generator)
    return pairs


def _onwards(
    ground: _TouchableSites, place: IntArray, heading: FloatArray, generator: np.random.Generator
) -> tuple[IntArray, FloatArray]:
    """The next place (k,) of straight ways over the skin and the heading (k, 3) there; at a border they turn."""
    step = _STEP * ground.pitch
    here = ground.positions[place]
    along = _tangent(heading, ground.normals[place])
    there = ground.nearest(here + step * along, ground.patch[place])
    moved = np.linalg.norm(ground.positions[there] - here, axis=1)
    stuck = moved < 0.5 * step
    return there, np.where(stuck[:, None], generator.normal(size=heading.shape), along)


def _tangent(vectors: FloatArray, normals: FloatArray) -> FloatArray:
    """(k, 3) unit vectors: ``vectors`` projected into the planes across ``normals``."""
    flat = vectors - (vectors * normals).sum(axis=1, keepdims=True) * normals
    return flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), np.finfo(float).tiny)


def _with_partners(ground: _TouchableSites, ways: IntArray, together: tuple[int, int] | None) -> _Ways:
    """Two at once: a place near one of two middles gets the place that lies alike from the other."""
    first, second = (ground.middle_of(taxel) for taxel in together or ground.farthest_taxels())
    partner = np.zeros(ways.shape, dtype=np.int64)
    joined = np.zeros(ways.shape, dtype=np.bool_)
    for here, there in ((first, second), (second, first)):
        offset = ground.positions[ways] - ground.positions[here]
        near = (np.linalg.norm(offset, axis=-1) < _BIASED_REGION * ground.pitch) & (
            ground.patch[ways] == ground.patch[here]
        )
        local = offset[near] @ _frame(ground.normals[here]).T
        points = ground.positions[there] + local @ _frame(ground.normals[there])
        partner[near] = ground.nearest(points, np.full(len(points), ground.patch[there]))
        joined |= near
    pressed = np.concatenate([np.ones_like(joined), joined], axis=-1)
    return _Ways(np.concatenate([ways, partner], axis=-1), pressed)


def _frame(normal: FloatArray) -> FloatArray:
    """(3, 3) rows: two unit vectors across ``normal``, and itself."""
    across = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    across /= np.linalg.norm(across)
    return np.stack([across, np.cross(normal, across), normal])
