"""Babbling: readings of random touches of a skin, from which maps are learned.

Touches are quasi-static and no robot moves. Each touch is a ball pressed on the skin, with the same contact model as in
a simulation, so that the statistics are those of this skin's taxels. A touch may also be a short stroke, so that
readings depend on time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, assert_never

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist, squareform

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import SimulationError, check_range
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load, sphere_load
from tactile_maps.tactile.mechanics.receptive_field import quadrature_points
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
    """Settings of random touches. A pitch is the spacing of the skin's taxels.

    Attributes:
        kind: ``unbiased``: one place at a time, uniform by area. ``self-touch``: two places of different patches press
            each other with the same force (any two on a skin of one patch). ``multi-touch``: three places at a time.
            ``biased``: like unbiased, but two distant places are always pressed together, which co-activation cannot
            distinguish from neighbours.
        touches: Number of touches, at least 1.
        samples: Readings in each touch: 1 is a poke; more are a stroke over the skin, 0.7 pitches per sample.
        rest: Readings without touch after each touch, which separate strokes.
        radius: Radius of the ball [m]; None is 4 pitches.
        force: Mean force [N]; each touch has 0.5 to 1.5 times as much. None gives a contact radius of 2 pitches.
        noise: Standard deviation of each reading, as a share of the mean pressure in the middle of a touch.
        together: The two taxels whose surroundings ``biased`` presses together; None selects the two that are farthest
            apart on the patch with the most taxels.
        seed: Seed of places, forces, strokes and noise.

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
                "unknown kind of babbling", value=self.kind, remedy=f"Choose one of: {', '.join(KINDS)}"
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
            check_range("the babbling setting", value, low, high, error=SimulationError, place=f"babbling.{name}")


def babble(skin: Skin, spec: BabbleSpec) -> FloatArray:
    """Return the readings of random touches; the same settings give the same readings, bit for bit.

    Args:
        skin: Skin with at least one taxel.
        spec: Settings of the touches.

    Returns:
        (touches * (samples + rest), taxels) pressures [Pa] in order of time. Noise makes some readings negative, like
        those of a sensor with baseline zero.

    Raises:
        SimulationError: The skin has no taxels, or lacks a taxel of ``together``.

    Cost: 0.4 to 0.8 s for 3000 pokes on 250 to 1000 taxels; more where more quadrature points are under the ball.
    """
    if not len(skin):
        raise SimulationError("the skin has no taxels for babbling", remedy="Cover at least one link")
    generator = np.random.default_rng(spec.seed)
    sites = _TouchableSites(skin)
    if spec.together is not None and not all(0 <= taxel < len(skin) for taxel in spec.together):
        remedy = f"Choose two of 0 to {len(skin) - 1}"
        raise SimulationError("unknown taxels to press together", value=spec.together, remedy=remedy)
    ways = _ways(sites, spec, generator)
    radius = _BALL * sites.pitch if spec.radius is None else spec.radius
    force = _footprint_force(_FOOTPRINT * sites.pitch, radius) if spec.force is None else spec.force
    forces = force * generator.uniform(0.5, 1.5, spec.touches)
    readings = np.zeros((spec.touches, spec.samples + spec.rest, len(skin)))
    model = WaterFillModel(skin)
    for touch in range(spec.touches):
        for sample in range(spec.samples):
            places = ways.sites[touch, sample][ways.pressed[touch, sample]]
            readings[touch, sample] = model.pressures([sites.load(p, forces[touch], radius) for p in places])
    middle = readings[:, : spec.samples].max(axis=2).mean()
    readings += generator.normal(scale=spec.noise * middle, size=readings.shape)
    return readings.reshape(-1, len(skin))


@dataclass(frozen=True, eq=False)
class TouchedPlaces(ArrayFields):
    """Places of touches on a skin.

    Attributes:
        positions: (touches, samples, simultaneous, 3) positions [m], link frames.
        patches: (touches, samples, simultaneous) their patches.
        pressed: (touches, samples, simultaneous) whether it is pressed; otherwise place and patch are undefined.
    """

    positions: FloatArray
    patches: IntArray
    pressed: BoolArray


def touched_places(skin: Skin, spec: BabbleSpec) -> TouchedPlaces:
    """Return the places that ``babble`` touches; the same settings give the same places.

    Args:
        skin: Skin with at least one taxel.
        spec: Settings, of which kind, touches, samples, together and seed are used.
    """
    sites = _TouchableSites(skin)
    ways = _ways(sites, spec, np.random.default_rng(spec.seed))
    return TouchedPlaces(sites.positions[ways.sites], sites.patch[ways.sites], ways.pressed)


def taxel_pitch(skin: Skin) -> float:
    """Return the spacing of a skin's taxels [m], that of a hexagonal lattice with their median area."""
    return float(np.sqrt(np.median(skin.areas) * 2 / np.sqrt(3)))


def _footprint_force(contact: float, ball: float) -> float:
    """Return the force [N] for a contact radius a of a ball R on a flat bed of springs K: pi K a^4 / (4 R)."""
    return np.pi * ElasticLayer().foundation * contact**4 / (4 * ball)


class _TouchableSites:
    """Places of a skin that can be touched: its quadrature points, numbered through the patches."""

    def __init__(self, skin: Skin) -> None:
        self._skin = skin
        points = quadrature_points(skin)
        self.positions = points.positions
        self.normals = points.normals
        self._shares = points.areas / points.areas.sum()
        self._taxel = points.taxel
        self.patch = skin.patch_of[points.taxel]
        self.pitch = taxel_pitch(skin)
        parts = [patch.taxels.quadrature.positions for patch in skin.patches]
        self._trees = [cKDTree(part) for part in parts]
        self._first = np.cumsum([0, *map(len, parts)])

    def load(self, place: int, force: float, radius: float) -> Load:
        link = self._skin.patches[self.patch[place]].link
        return sphere_load(link, self.positions[place], self.normals[place], force, radius)

    def anywhere(self, count: int, generator: np.random.Generator) -> IntArray:
        """Return (count,) random places, uniform by area."""
        return generator.choice(len(self._shares), count, p=self._shares)

    def middle_of(self, taxel: int) -> int:
        """Return the place nearest to the middle of a taxel's area."""
        own = np.flatnonzero(self._taxel == taxel)
        return int(own[np.linalg.norm(self.positions[own] - self.positions[own].mean(axis=0), axis=1).argmin()])

    def farthest_taxels(self) -> tuple[int, int]:
        """Return the two taxels that are farthest apart on the patch with the most taxels."""
        counts = np.diff(self._skin.first)
        patch = int(counts.argmax())
        apart = squareform(pdist(self._skin.patches[patch].taxels.positions))
        a, b = np.unravel_index(apart.argmax(), apart.shape)
        start = int(self._skin.first[patch])
        return start + int(a), start + int(b)

    def nearest(self, points: FloatArray, patch: IntArray) -> IntArray:
        """Return the place (k,) nearest to each point (k, 3) on its patch (k,)."""
        found = np.empty(len(points), dtype=np.int64)
        for number in np.unique(patch):
            here = patch == number
            found[here] = self._first[number] + self._trees[number].query(points[here])[1]
        return found


@dataclass(frozen=True, eq=False)
class _Ways:
    """(touches, samples, simultaneous) sites of ``_TouchableSites``, and whether each is pressed."""

    sites: IntArray
    pressed: BoolArray


def _ways(sites: _TouchableSites, spec: BabbleSpec, generator: np.random.Generator) -> _Ways:
    """Return the random places of each touch."""
    match spec.kind:
        case "unbiased" | "biased":
            start = sites.anywhere(spec.touches, generator)[:, None]
        case "multi-touch":
            start = sites.anywhere(_MANY * spec.touches, generator).reshape(-1, _MANY)
        case "self-touch":
            start = _pairs(sites, spec.touches, generator)
        case _:
            assert_never(spec.kind)
    way = [start.ravel()]
    heading = generator.normal(size=(start.size, 3))
    for _ in range(spec.samples - 1):
        place, heading = _onwards(sites, way[-1], heading, generator)
        way.append(place)
    ways = np.stack(way).reshape(spec.samples, *start.shape).transpose(1, 0, 2)
    if spec.kind == "biased":
        return _with_partners(sites, ways, spec.together)
    return _Ways(ways, np.ones(ways.shape, dtype=np.bool_))


def _pairs(sites: _TouchableSites, count: int, generator: np.random.Generator) -> IntArray:
    """Return (count, 2) places, each uniform by area, on different patches if the skin has several."""
    pairs = sites.anywhere(2 * count, generator).reshape(count, 2)
    several = len(np.unique(sites.patch)) > 1
    while several and (same := np.flatnonzero(sites.patch[pairs[:, 0]] == sites.patch[pairs[:, 1]])).size:
        pairs[same, 1] = sites.anywhere(len(same), generator)
    return pairs


def _onwards(
    sites: _TouchableSites, place: IntArray, heading: FloatArray, generator: np.random.Generator
) -> tuple[IntArray, FloatArray]:
    """Return the next place (k,) of strokes over the skin and the heading (k, 3) there; at a border they turn."""
    step = _STEP * sites.pitch
    here = sites.positions[place]
    along = _tangent(heading, sites.normals[place])
    there = sites.nearest(here + step * along, sites.patch[place])
    moved = np.linalg.norm(sites.positions[there] - here, axis=1)
    stuck = moved < 0.5 * step
    return there, np.where(stuck[:, None], generator.normal(size=heading.shape), along)


def _tangent(vectors: FloatArray, normals: FloatArray) -> FloatArray:
    """Return (k, 3) unit vectors: ``vectors`` projected into the planes perpendicular to ``normals``."""
    flat = vectors - (vectors * normals).sum(axis=1, keepdims=True) * normals
    return flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), np.finfo(float).tiny)


def _with_partners(sites: _TouchableSites, ways: IntArray, together: tuple[int, int] | None) -> _Ways:
    """Return places in pairs: a place near one of two centres gets the same place relative to the other centre."""
    first, second = (sites.middle_of(taxel) for taxel in together or sites.farthest_taxels())
    partner = np.zeros(ways.shape, dtype=np.int64)
    joined = np.zeros(ways.shape, dtype=np.bool_)
    for here, there in ((first, second), (second, first)):
        offset = sites.positions[ways] - sites.positions[here]
        near = (np.linalg.norm(offset, axis=-1) < _BIASED_REGION * sites.pitch) & (
            sites.patch[ways] == sites.patch[here]
        )
        local = offset[near] @ _frame(sites.normals[here]).T
        points = sites.positions[there] + local @ _frame(sites.normals[there])
        partner[near] = sites.nearest(points, np.full(len(points), sites.patch[there]))
        joined |= near
    pressed = np.concatenate([np.ones_like(joined), joined], axis=-1)
    return _Ways(np.concatenate([ways, partner], axis=-1), pressed)


def _frame(normal: FloatArray) -> FloatArray:
    """Return a frame (3, 3) whose last row is ``normal``."""
    across = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    across /= np.linalg.norm(across)
    return np.stack([across, np.cross(normal, across), normal])
