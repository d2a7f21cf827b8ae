"""Share of random touches whose true force and place are within the stated uncertainties and intervals.

A ball of 4 to 20 mm presses a random place of a skin with 0.5 to 10 N (both log-uniform). Its load begins at an unknown
time up to three time constants of the creep before it is read, or swings by half of itself at 0.2 to 2 Hz while a slow
skin is read or readings are means over time. Every touch has a sensor of its own: gains, offsets and dead taxels are
drawn again. Instead of a ball, a cylinder on its side or the face of a box presses skins that no width was fitted to.

``python -m tests.support.coverage`` prints the guide's table of these bodies (about half an hour).
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.pipeline import ContactPipeline, ReadingSettings
from tactile_maps.core.arrays import BoolArray, FloatArray
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.library import load_robot
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.fitting.cover import CoverSpec, cover_robot
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Box, Cylinder, Load, sphere_load
from tactile_maps.tactile.mechanics.receptive_field import cell_field, disc_field, quadrature_points
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS, ContactModel
from tactile_maps.tactile.sensors.sensor_chain import SensorChain
from tactile_maps.tactile.sensors.sensor_effects import (
    ALIVE,
    AreaAveraging,
    Crosstalk,
    DeadTaxels,
    GainSpread,
    Hysteresis,
    Noise,
    OffsetDrift,
    Quantisation,
    Sampling,
    Saturation,
    SensorEffects,
    Threshold,
)
from tests.support.touch import bar, bar_map, plate

TICK = 0.005
LAYER = ElasticLayer()
EFFECTS = MappingProxyType(
    {
        "none": SensorEffects(),
        "area averaging": SensorEffects(area_averaging=AreaAveraging()),
        "crosstalk": SensorEffects(crosstalk=Crosstalk()),
        "hysteresis": SensorEffects(hysteresis=Hysteresis()),
        "gain spread": SensorEffects(gain_spread=GainSpread()),
        "offset drift": SensorEffects(offset_drift=OffsetDrift()),
        "noise": SensorEffects(noise=Noise()),
        "saturation": SensorEffects(saturation=Saturation(10e3)),
        "threshold": SensorEffects(threshold=Threshold()),
        "quantisation": SensorEffects(quantisation=Quantisation()),
        "dead taxels": SensorEffects(dead_taxels=DeadTaxels()),
        "sampling": SensorEffects(sampling=Sampling()),
        "time averaging": SensorEffects(),
        "all": SensorEffects(
            area_averaging=AreaAveraging(),
            crosstalk=Crosstalk(),
            hysteresis=Hysteresis(),
            gain_spread=GainSpread(),
            offset_drift=OffsetDrift(),
            noise=Noise(),
            saturation=Saturation(),
            threshold=Threshold(),
            quantisation=Quantisation(),
            dead_taxels=DeadTaxels(),
            sampling=Sampling(),
        ),
    }
)
BODIES = MappingProxyType({"ball": 0.006, "cylinder": 0.016, "box": 0.019})
"""Bodies, with their least distance from the border of a skin of ``OTHER_SKINS`` [m]."""
RARE = 20
"""Shares of fewer touches are not printed."""
SLOW = frozenset({"hysteresis", "offset drift", "sampling", "time averaging", "all"})
"""Effects whose touches are read for a time."""
OTHER_SKINS = ("strip-110", "cap-130", "corner-160")
"""A flat strip, a cap of a sphere, and two patches at a right angle; no width was fitted to them."""
_CYLINDER = Cylinder(0.008, 0.015)
_BOX = Box((0.015, 0.01, 0.01))
MODELS = ("point", "water-fill", "punch", "half-space", "foundation", "depth")


@dataclass(frozen=True)
class Coverage:
    """Outcome of many touches.

    Forces that are stated to within 1e-4 count as exact: the shares of forces are those of the other touches.

    Attributes:
        found: Number of touches that were found.
        stated: (2,) number of touches whose standard uncertainty and whose interval are wider than that.
        force: (2,) share of their true forces within the standard uncertainty and within the interval; 1 for no touch.
        place: (2,) share of places within one and two standard uncertainties, which are radial.
        exact: Whether all forces are exact to rounding.
        ratio: Root mean square of the stated over that of the actual errors, of force and of place.
    """

    found: int
    stated: tuple[int, int]
    force: tuple[float, float]
    place: tuple[float, float]
    exact: bool
    ratio: tuple[float, float]


@cache
def skin_of(name: str) -> tuple[Robot, TactileMap]:
    """Return a robot and its map: ``arm-1000``, ``bar-400`` or one of ``OTHER_SKINS``."""
    kind, taxels = name.split("-")
    if kind == "bar":
        return bar(), bar_map(int(taxels))
    if name in OTHER_SKINS:
        return bar(), build_map(_other_skin(kind))
    robot = load_robot(kind)
    links = ("upper_arm", "forearm", "hand") if kind == "arm" else ()
    return robot, build_map(cover_robot(robot, CoverSpec(links, taxels=int(taxels))))


def _other_skin(kind: str) -> Skin:
    if kind == "strip":
        strip = plate((0.01, -0.03, 0.02), (0.3, 0, 0), (0, 0.06, 0), steps=(60, 12))
        return Skin((Patch("strip", "bar", strip, place_evenly(strip, 110, seed=3)),))
    if kind == "cap":
        cap = _cap(0.06, 1.0)
        return Skin((Patch("cap", "bar", cap, place_evenly(cap, 130, seed=4)),))
    top = plate((0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), steps=(24, 24))
    side = plate((0, 0, 0), (0, 0.1, 0), (0, 0, -0.1), steps=(24, 24))
    return Skin(
        (
            Patch("top", "bar", top, place_evenly(top, 70, seed=5)),
            Patch("side", "bar", side, place_evenly(side, 90, seed=6)),
        )
    )


def _cap(radius: float, angle: float, rings: int = 24, around: int = 48) -> Mesh:
    """Return the part of a sphere up to an ``angle`` [rad] from its pole."""
    polar, turn = np.meshgrid(
        angle * np.arange(1, rings + 1) / rings, 2 * np.pi * np.arange(around) / around, indexing="ij"
    )
    sphere = [np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)]
    vertices = np.vstack([[0, 0, 1], np.stack(sphere, axis=-1).reshape(-1, 3)])
    number = 1 + np.arange(rings * around).reshape(rings, around)
    following = np.roll(number, -1, axis=1)
    faces = [
        np.stack([np.zeros_like(number[0]), number[0], following[0]], axis=-1),
        np.stack([number[:-1], number[1:], following[1:]], axis=-1).reshape(-1, 3),
        np.stack([number[:-1], following[1:], following[:-1]], axis=-1).reshape(-1, 3),
    ]
    return Mesh(radius * vertices, np.concatenate(faces))


def _border(surface: Mesh) -> FloatArray:
    """Return the vertices (k, 3) on the border of a surface."""
    sides = np.sort(np.concatenate([surface.faces[:, [0, 1]], surface.faces[:, [1, 2]], surface.faces[:, [2, 0]]]))
    edges, counts = np.unique(sides, axis=0, return_counts=True)
    return surface.vertices[np.unique(edges[counts == 1])]


class _SpringBed:
    """``foundation`` and ``depth`` models of a ball at rest, without physics."""

    def __init__(self, skin: Skin, sensor: SensorEffects, *, depth: bool) -> None:
        self._skin = skin
        self._depth = depth
        self._points = quadrature_points(skin)
        averaging = sensor.area_averaging
        self._field = cell_field(skin) if averaging is None else disc_field(skin, averaging.radius)
        self._links = np.array([patch.link for patch in skin.patches])[skin.patch_of]
        self._positions = np.concatenate([patch.taxels.positions for patch in skin.patches])
        self.notes = ()

    def pressures(self, loads: list[Load]) -> FloatArray:
        (load,) = loads
        if self._depth:
            inside = np.maximum(-load.distances(self._positions), 0.0) * (self._links == load.link)
            return LAYER.foundation * inside
        points = self._points
        radius = load.shape.reach
        near = np.linalg.norm(points.positions - load.point, axis=1) < 2 * radius
        mine = np.flatnonzero((self._links[points.taxel] == load.link) & near)
        places = points.positions[mine]
        normals = points.normals[mine]
        areas = points.areas[mine]
        low = 0.0
        high = radius
        for _ in range(40):
            depth = 0.5 * (low + high)
            middle = load.point + (radius - depth) * load.normal
            offset = middle - places
            away = np.linalg.norm(offset, axis=1)
            forces = LAYER.foundation * np.maximum(radius - away, 0.0) * areas
            push = float(np.linalg.norm((forces / away) @ offset))
            low, high = (depth, high) if push < load.force else (low, depth)
        if depth > max(LAYER.thickness, 0.5 * radius):  # rejected because the ball presses through the cover
            return np.zeros(len(self._skin))
        felt = np.maximum(np.einsum("ij,ij->i", offset, normals) / away * forces, 0.0)
        pressed = np.flatnonzero(felt)
        pressures = np.zeros(len(self._skin))
        self._field.add(pressures, mine[pressed], felt[pressed])
        return pressures


@cache
def _model(skin_name: str, model: str, averaging: bool) -> ContactModel:
    _, map_ = skin_of(skin_name)
    sensor = EFFECTS["area averaging" if averaging else "none"]
    if model in ("foundation", "depth"):
        return _SpringBed(map_.skin, sensor, depth=model == "depth")
    return CONTACT_MODELS[model].build(map_.skin, LAYER, sensor)


@cache
def _touches(skin_name: str, model: str, averaging: bool, body: str, count: int) -> list[tuple[Load, FloatArray]]:
    random = np.random.default_rng(7)
    skin = skin_of(skin_name)[1].skin
    felt = _model(skin_name, model, averaging)
    borders = [_border(patch.surface) for patch in skin.patches] if skin_name in OTHER_SKINS else []
    areas = [patch.surface.face_areas for patch in skin.patches]
    owner = np.repeat(np.arange(len(areas)), [len(one) for one in areas])
    face = np.concatenate([np.arange(len(one)) for one in areas])
    whole = np.concatenate(areas)
    touches: list[tuple[Load, FloatArray]] = []
    while len(touches) < count:
        for number in random.choice(len(whole), count - len(touches), p=whole / whole.sum()):
            weights = random.dirichlet((1.0, 1.0, 1.0))
            at = SurfacePoint(int(owner[number]), int(face[number]), tuple(weights.tolist()))
            force = math.exp(random.uniform(*np.log((0.5, 10.0))))
            load = _load(body, skin, at, force, random)
            away = [np.linalg.norm(borders[at.patch] - load.point, axis=1).min()] if borders else []
            if min(away, default=np.inf) >= BODIES[body]:
                touches.append((load, felt.pressures([load])))
    return touches


def _load(body: str, skin: Skin, at: SurfacePoint, force: float, random: np.random.Generator) -> Load:
    """Return the load of a body that presses a place; cylinders and boxes are turned randomly about the normal."""
    link, point, normal = skin.link(at), skin.position(at), skin.normal(at)
    depth = force / LAYER.stiffness
    if body == "ball":
        radius = math.exp(random.uniform(*np.log((4e-3, 0.02))))
        return sphere_load(link, point, normal, force, radius, depth=depth)
    along = np.cross(normal, random.standard_normal(3))
    along /= np.linalg.norm(along)
    if body == "cylinder":
        turned = np.column_stack([normal, np.cross(along, normal), along])
        pose = Pose(turned, point + (_CYLINDER.radius - depth) * normal)
        return Load(link, point, normal, force, _CYLINDER, pose)
    turned = np.column_stack([along, np.cross(normal, along), normal])
    return Load(link, point, normal, force, _BOX, Pose(turned, point + (_BOX.half[2] - depth) * normal))


def _seen(
    pipeline: ContactPipeline,
    chain: SensorChain,
    felt: FloatArray,
    random: np.random.Generator,
    load: Load,
    step: float,
    averages: bool,
) -> tuple[tuple[ContactRegion, ...], float]:
    """Return the contacts at the end of a touch, and the true force [N] at that time."""
    sensor = chain._effects
    wrench = {load.link: np.concatenate([-load.force * load.normal, np.cross(load.point, -load.force * load.normal)])}
    seconds = 0.0
    last = 1
    if sensor.hysteresis is not None or sensor.offset_drift is not None:
        seconds = random.uniform(0, 3.0)
    rate = 0.0
    phase = 0.0
    swing = 0.0
    if sensor.sampling is not None or averages:
        last = 40
        swing = 0.5
        rate = random.uniform(0.2, 2.0)
        phase = random.uniform(0, 2 * math.pi)
        seconds += (40 * step if averages else 0.2) + random.uniform(0, 0.04)
    ticks = math.floor(seconds / step) + 1
    regions: tuple[ContactRegion, ...] = ()
    now = 1.0
    for tick in range(ticks):
        now = 1 + swing * math.sin(2 * math.pi * rate * step * tick + phase)
        mean = now
        if averages:
            turn = 2 * math.pi * rate * step
            angle = turn * tick + phase
            mean = 1 + swing * (math.cos(angle - turn) - math.cos(angle)) / turn
        pressures = chain.read(felt * mean)
        if tick >= ticks - last:
            wrenches = {link: now * w for link, w in wrench.items()}
            regions = pipeline.read(tick, tick * step, np.zeros(0), pressures, wrenches=wrenches)
    return regions, now * load.force


def touch_errors(
    skin_name: str,
    model: str = "water-fill",
    effect: str = "none",
    estimator: str = "area-sum",
    *,
    body: str = "ball",
    count: int = 300,
    wrench_noise: float = 0.1,
) -> FloatArray:
    """Press ``count`` times; return (found, 7) errors and uncertainties.

    Columns: error of the force and its uncertainty [N], the same of the place [m], the force, and the lowest and
    highest force of the interval [N].
    """
    robot, map_ = skin_of(skin_name)
    sensor = EFFECTS[effect]
    random = np.random.default_rng(11)
    settings = ReadingSettings(estimator, wrench_noise=wrench_noise if estimator == "lumped" else 0.0)
    rows = []
    for seed, (load, felt) in enumerate(_touches(skin_name, model, sensor.area_averaging is not None, body, count)):
        tick = TICK if sensor.sampling else 10 * TICK
        averages = effect == "time averaging"
        chain = SensorChain(map_.skin, sensor, tick=tick, seed=seed)
        if not seed or estimator == "lumped":  # a reset repeats the noise of the force-torque sensor
            pipeline = ContactPipeline(robot, map_, sensor, settings=settings, depth=LAYER.depth, seed=seed)
            pipeline.set_sensor_model(sensor, averaged=tick if averages else 0.0, model=model)
        pipeline.set_broken_taxels(chain.dead != ALIVE)
        pipeline.reset()
        regions, force = _seen(pipeline, chain, felt, random, load, tick, averages)
        regions = tuple(region for region in regions if region.link == load.link)
        if not regions:
            continue
        region = regions[0]
        away = float(np.linalg.norm(region.link_position - load.point))
        interval = region.force_interval
        rows.append((region.force - force, region.force_error, away, region.place_error, force, *interval))
    return np.array(rows).reshape(-1, 7)


_EXACT = 1e-4


def _share(within: BoolArray, among: BoolArray) -> float:
    return float(within[among].mean()) if among.any() else 1.0


def coverage(
    skin_name: str,
    model: str = "water-fill",
    effect: str = "none",
    estimator: str = "area-sum",
    *,
    count: int = 300,
) -> Coverage:
    """Compare actual and stated errors of ``count`` touches; see the module."""
    return coverage_of(touch_errors(skin_name, model, effect, estimator, count=count))


def coverage_of(table: FloatArray) -> Coverage:
    """Compare actual and stated errors in rows of ``touch_errors``."""
    off = np.abs(table[:, 0])
    said = table[:, 1]
    away = table[:, 2]
    place = table[:, 3]
    force = table[:, 4]
    low = table[:, 5]
    high = table[:, 6]
    slack = 1e-9 * force
    stated = said > _EXACT * force, high - low > 2 * _EXACT * force
    within = off <= said + slack, (low - slack <= force) & (force <= high + slack)
    return Coverage(
        len(table),
        (int(stated[0].sum()), int(stated[1].sum())),
        (_share(within[0], stated[0]), _share(within[1], stated[1])),
        tuple(float((away <= k * place + 1e-9).mean()) for k in (1, 2)),
        bool((off <= slack).all()),
        (
            float(np.sqrt(np.mean(said**2)) / max(np.sqrt(np.mean(off**2)), 1e-12)),
            float(np.sqrt(np.mean(place**2)) / max(np.sqrt(np.mean(away**2)), 1e-12)),
        ),
    )


def other_bodies() -> Iterator[str]:
    """Yield the guide's table of the lowest and highest share of three skins, by effect and body."""
    yield f"| effect | {' | '.join(BODIES)} |"
    yield "|---" * (1 + len(BODIES)) + "|"
    for effect in EFFECTS:
        cells = []
        count = 300 if effect in SLOW else 1000
        for body in BODIES:
            tables = [touch_errors(skin, effect=effect, body=body, count=count) for skin in OTHER_SKINS]
            found = [coverage_of(table) for table in tables]
            shares = [[one.force[k] for one in found if one.stated[k] >= RARE] for k in (0, 1)]
            cells.append(", ".join(f"{min(each):.2f} to {max(each):.2f}" for each in shares if each) or "exact")
        yield f"| {effect} | {' | '.join(cells)} |"


if __name__ == "__main__":
    for line in other_bodies():
        sys.stdout.write(line + "\n")
