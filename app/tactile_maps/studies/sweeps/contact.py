"""Does contact obey mechanics? Shapes on skins, with every contact model, integrator and time step, against statics.

Each row is one check of one combination, with measured quantities and a verdict. References follow from mechanics
alone: weight, the place below the centre of mass, Coulomb friction, momentum, energy, the third law and mirror
symmetry. ``EXCEPTIONS`` lists the rows known to be outside their tolerances, each with the reason.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from scipy.optimize import curve_fit
from scipy.spatial.transform import Rotation

from tactile_maps.control.motion.command import JointCommand
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import SimulationError
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.object_meshes import primitive_mesh
from tactile_maps.scene.objects import ObjectSpec, SceneObject
from tactile_maps.simulation.model.contact_stiffness import SOLVER_IMPEDANCE
from tactile_maps.simulation.model.object_geoms import PROBE_STIFFNESS
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.model.bare_surface import with_bare_points
from tactile_maps.skin.model.skin import Skin
from tactile_maps.studies.base.figures import Figure
from tactile_maps.studies.base.rows import Case, Row
from tactile_maps.studies.stages.simulation import INTEGRATORS
from tactile_maps.studies.study.study import Study
from tactile_maps.studies.testbeds.contact_bench import (
    BODIES,
    CONCAVE,
    CONVEX,
    FRICTION,
    GRAVITY,
    MASS,
    PITCH,
    SKINS,
    STIFFNESS,
    Bench,
    bench,
    facing_skins,
    lay,
)
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind, contact_note_text
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS, ContactModel
from tactile_maps.tactile.models.foundation import RELAXATION
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects

SOLVER = ("point", "water-fill", "punch", "half-space")
"""Contact models whose forces come from the solver."""
PHYSICS: Mapping[str, tuple[str, ...]] = {"solver": SOLVER, "foundation": ("foundation",), "depth": ("depth",)}
"""Contact models by the simulation that serves them; one simulation serves all models of the solver."""
STEPS_MS = (0.5, 1.0, 2.0, 4.0)
RATIOS = (1, 5, 20)
MOTIONS = ("guided", "free", "scripted", "stacked")
MODELS = tuple(model for models in PHYSICS.values() for model in models)
TOLERANCES: Mapping[str, float] = {
    "weight_percent": 0.5,
    "centre_mm": 1e3 * PITCH / 10,
    "creep_mm_s": 0.1,
    "spin_deg_s": 0.1,
    "flicker_percent": 0.1,
    "slide_percent": 1.0,
    "impulse_percent": 2.0,
    "rebound_percent": 100.0,
    "decay_percent": 5.0,
    "balance": 1e-12,
    "mirror_mm": 1e3 * PITCH / 1000,
}
"""Largest absolute value of each measured quantity. Rebound is the highest point after an impact, as a share of the
height of the fall."""
OK = "ok"
OUTSIDE = "outside"
REJECTED = "rejected"
_SETTLING = 0.6
"""Simulated time before a body at rest is observed [s]."""
_SOFT_SETTLING: Mapping[str, float] = {
    "sphere": 3.0,
    "disc": 1.2,
    "roller": 2.0,
    "box on face": 1.2,
    "box on edge": 4.0,
    "box on corner": 8.0,
    "mesh": 1.2,
}
"""Simulated time before a body is observed on the foundation, whose damping is weak under a small contact [s]."""
_WATCHED = 0.2
_STACKED = 0.02
"""Height of the bodies that support others [m]."""
_ASIDE = (0.0033, -0.0027)
"""Place of the bodies, away from all symmetries of the taxels [m]."""
_SLOPE = 0.12
"""Place x of a ball on the convex skin as a share of the radius of its centre's circle."""
_SYMMETRIC = ("sphere", "disc", "roller", "box on face", "box on edge")
"""Shapes that are their own mirror images about x."""
_DROP = 0.01
"""Height of a fall [m]."""
_STEEP = math.radians(5.0)
_COVER = ElasticLayer(stiffness=STIFFNESS)
_NONE = np.zeros(0)
_STILL = JointCommand(_NONE, _NONE, _NONE, _NONE)
_PROBE_MASS = 0.2


@dataclass(frozen=True)
class KnownException:
    """Rows that are known not to be ``ok``.

    Attributes:
        check: Name of the check; this and the next three are patterns with ``*``, several separated by ``|``.
        skin: Skin.
        shape: Shape.
        model: Contact model.
        reason: Cause, for people.
        where: Patterns of further columns.
    """

    check: str
    skin: str
    shape: str
    model: str
    reason: str
    where: Mapping[str, str] | None = None

    def covers(self, row: Row) -> bool:
        """Whether a row is one of these."""
        patterns = {"check": self.check, "skin": self.skin, "shape": self.shape, "model": self.model}
        patterns |= self.where or {}
        return all(
            any(fnmatch(str(row[column]), part) for part in pattern.split("|")) for column, pattern in patterns.items()
        )


_SPACED = "the share of skin and bare surface is counted by points 2 mm apart under contacts of 3 to 30 mm"
_PIECES = (
    "a concave link collides as convex pieces, which differ from the skin by as much as the cover is compressed: where "
    "two places touch at once, one carries too much, and punch keeps the centre that results"
)
_BETWEEN = "the model reads the overlap at the taxels' points only; a contact that fits between them is not read"
_FACET = (
    "under a face, MuJoCo detects contact with one facet of the hull only, so the centre of the contact is up to half "
    "a facet off, here 1 mm; punch keeps that centre"
)
EXCEPTIONS: Sequence[KnownException] = (
    KnownException(
        "rest",
        "flat",
        "mesh",
        "water-fill|half-space",
        "the springs of these models do not tilt: they keep the force of a face that is loaded unevenly, but not its "
        "moment; punch keeps both",
        {"motion": "free"},
    ),
    KnownException("rest", "convex", "box on face|mesh", "punch", _FACET),
    KnownException(
        "rest",
        "border",
        "*",
        "point",
        "the whole load is on the nearest point, which is either on the skin or on bare surface next to it",
    ),
    KnownException("rest", "border", "roller|box on face|box on edge|mesh", "water-fill|half-space", _SPACED),
    KnownException("rest", "border", "box on edge", "punch", _SPACED),
    KnownException("rest", "border", "box on edge", "foundation", _SPACED),
    KnownException("mirror", "convex", "disc|box on face|mesh", "punch", _FACET),
    KnownException("rest", "concave", "roller|box on face|box on edge|mesh", "punch", _PIECES),
    KnownException("rest", "concave", "roller|box on edge", "point", _PIECES),
    KnownException(
        "mirror", "concave", "disc|roller|box on face|box on edge|mesh", "water-fill|punch|half-space", _PIECES
    ),
    KnownException("mirror", "concave", "box on corner", "water-fill|punch", _PIECES),
    KnownException(
        "rest", "concave", "mesh", "foundation", "few points, 2 mm apart, are under the corners of the tilted block"
    ),
    KnownException("rest", "flat|border", "box on corner", "depth", _BETWEEN),
    KnownException("mirror", "flat", "sphere|roller|box on edge|box on corner", "depth", _BETWEEN),
    KnownException("rest", "convex", "box on edge|box on corner", "depth", _BETWEEN),
    KnownException("rest", "concave", "disc|box on face|box on edge|box on corner|mesh", "depth", _BETWEEN),
    KnownException(
        "rest",
        "flat",
        "mesh",
        "depth",
        "the model reads the overlap of the shapes, whose centre is not that of the force",
        {"motion": "free"},
    ),
)


def exception_of(row: Row) -> KnownException | None:
    """Return the known exception that covers a row; None where the row must be ``ok`` or ``rejected``."""
    return next((known for known in EXCEPTIONS if known.covers(row)), None)


def cases(quick: bool, seed: int) -> list[Case]:
    """Return every shape on every skin at rest, and the other checks over integrators, steps, ratios and motions.

    Skins, shapes and models are a full product at the default integrator and step. Integrators, steps and motions are a
    full product too, with shapes and ratios distributed so that every pair of values occurs.
    """
    found = [*_rest_cases(), *_motion_cases(), *_slope_cases(), *_impact_cases(), *_decay_cases(), *_symmetry_cases()]
    kept = found[::17] if quick else found
    return [{**case, "seed": seed} for case in kept]


def _case(check: str, skin: str, shape: str, physics: str, motion: str, **varied: Any) -> Case:
    case = {"check": check, "skin": skin, "shape": shape, "physics": physics, "motion": motion}
    return {**case, "integrator": "implicitfast", "timestep_ms": 1.0, "ratio": 5, **varied}


def _steps() -> Iterator[tuple[int, int, Mapping[str, Any]]]:
    """Every integrator with every time step, with their numbers."""
    for (first, integrator), (second, step) in product(enumerate(INTEGRATORS), enumerate(STEPS_MS)):
        yield first, second, {"integrator": integrator, "timestep_ms": step}


def _rest_cases() -> Iterator[Case]:
    for skin, shape, physics in product(SKINS, BODIES, PHYSICS):
        # The foundation has no friction: only a flat skin keeps a free body in place.
        level = skin == "flat" or (skin == "bare" and physics != "foundation")
        free = level and not BODIES[shape].guided
        yield _case("rest", skin, shape, physics, "free" if free else "guided")


def _motion_cases() -> Iterator[Case]:
    shapes = {
        "guided": ("sphere", "box on edge", "box on corner", "mesh"),
        "free": ("box on face", "disc", "mesh", "roller"),
        "scripted": ("sphere",) * 4,
        "stacked": ("box on face", "disc", "box on face", "disc"),
    }
    for first, second, step in _steps():
        for third, motion in enumerate(MOTIONS):
            # A Latin square: every pair of shape or ratio with integrator, step and motion.
            ratio = RATIOS[(first + 2 * second + third) % 3]
            yield _case("rest", "flat", shapes[motion][(first + second) % 4], "solver", motion, **step, ratio=ratio)
    for first, second, step in _steps():
        motion = ("guided", "free", "stacked", "scripted")[(first + 2 * second) % 4]
        physics = ("foundation", "depth")[(first + second) % 2]
        yield _case("rest", "flat", shapes[motion][(first + second) % 4], physics, motion, **step)


def _slope_cases() -> Iterator[Case]:
    for check in ("stick", "slip"):
        for first, second, step in _steps():
            shape = ("box on face", "disc", "mesh")[(first + 2 * second) % 3]
            yield _case(check, "flat", shape, "solver", "free", **step, ratio=RATIOS[(first + second) % 3])
        for physics in ("foundation", "depth"):
            yield _case(check, "flat", "box on face", physics, "free")


def _impact_cases() -> Iterator[Case]:
    shapes = ("sphere", "box on face", "disc", "mesh")
    for first, second, step in _steps():
        for third, ratio in enumerate(RATIOS):
            shape = shapes[(first + second + third) % 4]
            yield _case("impact", "flat", shape, "solver", "guided", **step, ratio=ratio)
        shape = shapes[(first + second) % 4]
        ratio = RATIOS[(first + 2 * second) % 3]
        yield _case("impact", "flat", shape, "foundation", "guided", **step, ratio=ratio)
    for skin, physics in product(("convex", "concave"), ("solver", "foundation")):
        yield _case("impact", skin, "sphere", physics, "guided")


def _decay_cases() -> Iterator[Case]:
    for physics in ("solver", "foundation"):
        for _, _, step in _steps():
            yield _case("decay", "flat", "box on face", physics, "guided", **step, ratio=1)


def _symmetry_cases() -> Iterator[Case]:
    for physics, skin in product(("solver", "foundation"), ("flat", "convex")):
        for integrator in INTEGRATORS if physics == "solver" else INTEGRATORS[:1]:
            yield _case("third law", skin, "skin", physics, "guided", integrator=integrator)
    for shape in BODIES:
        for skin in ("flat", "convex", "concave"):
            yield _case("mirror", skin, shape, "solver", "guided")
        for physics in ("foundation", "depth"):
            yield _case("mirror", "flat", shape, physics, "guided")


def measure(case: Case) -> list[Row]:
    """Return one row a contact model: what was measured, the verdict and its reason."""
    try:
        rows = _CHECKS[case["check"]](case)
    except SimulationError as error:
        rows = [{"model": model, "note": str(error)} for model in PHYSICS[case["physics"]]]
    return [_judged(case, row) for row in rows]


def _judged(case: Case, row: Row) -> Row:
    """Return a row with every column: rejected where it has a note, otherwise judged by the tolerances."""
    values = {column: row.get(column) for column in TOLERANCES}
    beyond = [
        column
        for column, value in values.items()
        if isinstance(value, float) and not abs(value) <= tolerance(column, str(row["model"]))
    ]
    note = str(row["note"])
    verdict = REJECTED if note else OUTSIDE if beyond else OK
    if verdict == OUTSIDE:
        known = exception_of({**case, **row})
        note = ", ".join(f"{column} {values[column]:.3g}" for column in beyond)
        note += f": {known.reason}" if known else ""
    rounded = {column: value if value is None else float(f"{value:.4g}") for column, value in values.items()}
    return {"model": row["model"], "verdict": verdict, **rounded, "note": note}


def tolerance(column: str, model: str) -> float:
    """Return the tolerance of a quantity; the model ``point`` promises the nearest taxel only: half a pitch."""
    return 1e3 * PITCH / 2 if (column, model) == ("centre_mm", "point") else TOLERANCES[column]


@dataclass(frozen=True, eq=False)
class _Reading:
    """The readings of one contact model over a run.

    Attributes:
        model: Its name.
        forces: (ticks, taxels) [N].
        ratios: (ticks,) sum of the readings over the force, as the program states it for contacts on bent skin.
    """

    model: str
    forces: FloatArray
    ratios: FloatArray

    @property
    def total(self) -> FloatArray:
        """(ticks,) force that the taxels read [N], by the stated ratio."""
        return np.asarray(self.forces.sum(axis=1) / self.ratios)

    def centre(self, skin: Skin) -> FloatArray:
        """(3,) centre of the mean reading [m], block frame; NaN without one."""
        mean = self.forces.mean(axis=0)
        return mean @ skin.positions / mean.sum() if mean.sum() > 0 else np.full(3, np.nan)


@dataclass(frozen=True, eq=False)
class _Run:
    """Observations of a simulation.

    Attributes:
        readings: Readings of each contact model.
        poses: (ticks, objects, 4, 4).
        tick: Duration of a tick [s].
        note: Instability that the program reports; empty for a valid run.
        outside: Whether a body was reported as outside the skin.
    """

    readings: Sequence[_Reading]
    poses: FloatArray
    tick: float
    note: str
    outside: bool


class _Lab:
    """A simulation of one case, read tick by tick by each of its contact models."""

    def __init__(
        self,
        case: Case,
        made: Bench,
        objects: Sequence[SceneObject],
        *,
        skin: Skin | None = None,
        layer: ElasticLayer = _COVER,
        friction: bool = False,
    ) -> None:
        self._physics = case["physics"]
        self._ratio = case["ratio"]
        self.skin = skin or made.points
        effects = Effects(
            contact="environment",
            gravity="on",
            fingers=False,
            friction=friction,
            time_averaging=True,
            timestep=1e-3 * case["timestep_ms"],
            integrator=case["integrator"],
            skin="water-fill" if self._physics == "solver" else self._physics,
        )
        self.simulation = Simulation(made.robot, self.skin, effects, objects=objects, layer=layer)
        self.models = _models(made.robot, self.skin, layer) if self._physics == "solver" else {}
        self.tick = self._ratio * effects.timestep

    def run(self, seconds: float, command: JointCommand = _STILL) -> None:
        """Advance without reading."""
        self.simulation.step(max(round(seconds / self.simulation.timestep), 1), command)

    def watch(self, seconds: float, command: JointCommand = _STILL) -> _Run:
        """Advance and read every tick."""
        simulation = self.simulation
        felt = []
        poses = []
        ratios = []
        outside = False
        for _ in range(max(round(seconds / self.tick), 1)):
            simulation.step(self._ratio, command)
            felt.append(self._read())
            poses.append(simulation.object_poses)
            notes = (*simulation.notes, *(note for model in self.models.values() for note in model.notes))
            outside |= any(note.kind is ContactNoteKind.OUTSIDE_SKIN for note in notes)
            ratios.append(next((note.ratio for note in simulation.notes if note.ratio), 1.0))
        names = self.models or PHYSICS[self._physics]
        forces = np.array(felt) * self.skin.areas
        unstable = [
            contact_note_text(note)
            for note in simulation.notes
            if note.kind in (ContactNoteKind.UNSTABLE, ContactNoteKind.SOFTER, ContactNoteKind.UNSTABLE_SERVO)
        ]
        readings = [_Reading(name, forces[:, number], np.array(ratios)) for number, name in enumerate(names)]
        return _Run(readings, np.array(poses), self.tick, "; ".join(unstable), outside)

    def _read(self) -> list[FloatArray]:
        if self._physics != "solver":
            return [self.simulation.sense()]
        loads = self.simulation.loads
        return [model.pressures(loads) for model in self.models.values()]


@lru_cache(maxsize=8)
def _models(robot: Robot, skin: Skin, layer: ElasticLayer) -> Mapping[str, ContactModel]:
    surface = with_bare_points(robot, skin)
    return {name: CONTACT_MODELS[name].build(surface, layer, SensorEffects()) for name in SOLVER}


def _rest(case: Case) -> list[Row]:
    """A body at rest: weight, centre, creep, spin and flicker."""
    made = bench(case["skin"])
    motion = case["motion"]
    if motion == "scripted":
        return _scripted(case, made)
    at = _place(case["skin"], case["shape"])
    # On the border a body that touches along a line crosses it.
    crosses = case["skin"] == "border" and BODIES[case["shape"]].reach[0] == 0
    objects = [lay(case["shape"], at, guided=motion == "guided", yaw=90.0 if crosses else 0.0)]
    weight = MASS * GRAVITY
    if motion == "stacked":
        objects.append(lay("box on face", (at[0], at[1], _STACKED), mass=0.5 * MASS, called="upper"))
        weight *= 1.5
    lab = _Lab(case, made, objects, friction=motion in ("free", "stacked"))
    soft = _SOFT_SETTLING if case["physics"] == "foundation" else {}
    lab.run(soft.get(case["shape"], _SETTLING))
    run = lab.watch(_WATCHED)
    share, centre = _expected(case, at)
    return [_rest_row(case, run, lab.skin, reading, weight * share, centre) for reading in run.readings]


def _rest_row(
    case: Case, run: _Run, skin: Skin, reading: _Reading, force: float, centre: tuple[float | None, float]
) -> Row:
    row: dict[str, float | str | None] = {"model": reading.model, "note": run.note, **_stillness(run, reading)}
    total = float(reading.total.mean())
    if case["skin"] == "bare":
        row["weight_percent"] = 0.0 if total == 0 and run.outside else 100.0
        return row
    if reading.model != "depth":  # which reads overlap, not force
        row["weight_percent"] = 100 * (total / force - 1)
    found = reading.centre(skin)
    off = [place - expected for place, expected in zip(found[:2].tolist(), centre, strict=True) if expected is not None]
    row["centre_mm"] = 1e3 * math.hypot(*off)
    return row


def _stillness(run: _Run, reading: _Reading) -> dict[str, float]:
    seconds = run.tick * (len(run.poses) - 1)
    moved = np.linalg.norm(run.poses[-1, :, :3, 3] - run.poses[0, :, :3, 3], axis=1).max()
    turns = Rotation.from_matrix(run.poses[-1, :, :3, :3] @ run.poses[0, :, :3, :3].transpose(0, 2, 1)).magnitude()
    total = reading.total
    return {
        "creep_mm_s": float(1e3 * moved / seconds),
        "spin_deg_s": float(np.degrees(turns.max()) / seconds),
        "flicker_percent": float(100 * total.std() / total.mean()) if total.mean() > 0 else 0.0,
    }


def _place(skin: str, shape: str) -> tuple[float, float, float]:
    """Return where a body is laid: its lowest point, block frame [m]."""
    x, y = _ASIDE
    if skin == "concave":
        return (0.0, 0.0, _sagging(shape))
    if skin == "convex" and shape == "sphere":
        x = _SLOPE * (CONVEX + BODIES[shape].size[0])
        along = math.sqrt(1 - _SLOPE**2)
        return (x, y, (CONVEX + BODIES[shape].size[0]) * along - CONVEX - BODIES[shape].size[0])
    return (x if skin == "flat" else 0.0, y, 0.0)


def _rim(shape: str) -> float:
    """Return how far from the axis a body touches a bowl [m]."""
    reach = BODIES[shape].reach
    return reach[0] if shape == "disc" else math.hypot(*reach)


def _sagging(shape: str) -> float:
    """Return the height at which a body rests on the rim of what touches the concave skin [m]."""
    return CONCAVE - math.sqrt(CONCAVE**2 - _rim(shape) ** 2)


def _expected(case: Case, at: tuple[float, float, float]) -> tuple[float, tuple[float | None, float]]:
    """Return the force that is read as a share of the weight, and the centre's x and y [m]; None where unknown.

    Statics: the normal force of a guided ball is along the normal of the skin, so that it is the weight over the cosine
    of the slope. Around the axis of a hollow, slopes on opposite sides cancel: the forces along their mean normal sum
    to the weight.
    """
    body = BODIES[case["shape"]]
    skin = case["skin"]
    if skin == "concave":
        return 1.0, (0.0, 0.0)
    if skin == "convex" and case["shape"] == "sphere":
        return 1 / math.sqrt(1 - _SLOPE**2), (CONVEX * _SLOPE, at[1])
    if skin == "border":
        half = {"disc": 4 / (3 * math.pi) * body.reach[0]}.get(case["shape"], max(body.reach) / 2)
        return 0.5, (half if max(body.reach) else None, at[1])
    aside = body.aside if case["motion"] == "free" else 0.0
    return 1.0, (at[0] + aside, at[1])


def _scripted(case: Case, made: Bench) -> list[Row]:
    """A probe comes down, slides and rests: its motors are springs, so that its pose gives the force."""
    radius, deep, (x, y) = 0.01, 0.005, _ASIDE
    path = (
        (0.0, x - 0.02, y, radius + 0.002),
        (0.2, x - 0.02, y, radius - deep),
        (0.4, x, y, radius - deep),
        (60.0, x, y, radius - deep),
    )
    spec = ObjectSpec("probe", "probe", (radius,), mass=_PROBE_MASS, friction=0.0, max_force=50.0, path=path)
    lab = _Lab(case, made, [SceneObject(spec, primitive_mesh(spec))])
    lab.run(0.4 + _SETTLING)
    run = lab.watch(_WATCHED)
    stretch = np.array(path[-1][1:]) - run.poses[-1, 0, :3, 3]
    force = PROBE_STIFFNESS * float(np.linalg.norm(stretch))
    return [_rest_row(case, run, lab.skin, reading, force, (x, y)) for reading in run.readings]


def _stick(case: Case) -> list[Row]:
    """Below the friction angle a body stays."""
    return _on_slope(case, 0.95 * math.atan(FRICTION))


def _slip(case: Case) -> list[Row]:
    """A body slides beyond it with  g (sin a - mu cos a)."""
    return _on_slope(case, math.atan(FRICTION) + _STEEP)


def _on_slope(case: Case, slope: float) -> list[Row]:
    if case["physics"] == "foundation":
        return [{"model": "foundation", "note": "the foundation has no friction; the panel Effects reports this"}]
    slips = case["check"] == "slip"
    deep = MASS * GRAVITY * math.cos(slope) / STIFFNESS
    at = (-0.02 if slips else _ASIDE[0], _ASIDE[1], -deep)
    made = bench(case["skin"], slope)
    lab = _Lab(case, made, [lay(case["shape"], at, slope=slope)], friction=True)
    if not slips:
        lab.run(0.5)
    start = lab.simulation.object_poses[0, :3, 3]
    run = lab.watch(0.3)
    force = MASS * GRAVITY * math.cos(slope)
    downhill = np.array([math.cos(slope), 0.0, -math.sin(slope)])
    rows: list[Row] = []
    for reading in run.readings:
        row: dict[str, float | str | None] = {"model": reading.model, "note": run.note}
        if slips:
            gone = (run.poses[:, 0, :3, 3] - start) @ downhill
            times = run.tick * np.arange(1, len(gone) + 1)
            (_, half), *_ = np.linalg.lstsq(np.stack([times, times**2], axis=1), gone)
            found = 2 * float(half)
            expected = GRAVITY * (math.sin(slope) - FRICTION * math.cos(slope))
            row["slide_percent"] = 100 * (found / expected - 1)
        else:
            row |= _stillness(run, reading)
        if reading.model != "depth":
            row["weight_percent"] = 100 * (float(reading.total.mean()) / force - 1)
        rows.append(row)
    return rows


def _impact(case: Case) -> list[Row]:
    """A body falls and comes to rest: the impulse that is read is weight times time, and no energy is gained."""
    x, y, z = _place(case["skin"], case["shape"])
    if case["skin"] == "convex":
        x = 0.0
        z = 0.0
    lab = _Lab(case, bench(case["skin"]), [lay(case["shape"], (x, y, z + _DROP), guided=True)])
    run = lab.watch(0.6)
    seconds = run.tick * len(run.poses)
    height = run.poses[:, 0, 2, 3]
    least = int(height.argmin())
    rebound = 100 * (float(height[least:].max()) - float(height[-1])) / _DROP
    return [
        {
            "model": reading.model,
            "note": run.note,
            "impulse_percent": 100 * (float(reading.total.sum()) * run.tick / (MASS * GRAVITY * seconds) - 1),
            "rebound_percent": rebound,
        }
        for reading in run.readings
    ]


def _decay(case: Case) -> list[Row]:
    """A body released from a deeper place returns with the rate of its spring and damper, c / (2 m)."""
    solver = case["physics"] == "solver"
    if solver:
        layer = ElasticLayer(stiffness=2e3)
        mass = 2.0
        stiffness = layer.stiffness
        more = 2e-3
        seconds = 0.3
        # The solver's contact is critically damped, and its impedance d adds the mass  m d / (1 - d)  to the body's.
        rate = math.sqrt(stiffness * (1 - SOLVER_IMPEDANCE) / mass)
    else:
        layer = _COVER
        mass = MASS
        length, width = BODIES[case["shape"]].reach
        stiffness = layer.foundation * 4 * length * width
        more = 5e-5
        seconds = 0.15
        rate = 0.5 * RELAXATION * stiffness / mass
    # Its sides are on the borders of the surface's squares, so that it has all of its springs.
    body = lay(case["shape"], (0.001, 0.0, -mass * GRAVITY / stiffness - more), mass=mass, guided=True)
    run = _Lab(case, bench(case["skin"]), [body], layer=layer).watch(seconds)
    heights = run.poses[:, 0, 2, 3]
    times = run.tick * np.arange(1, len(heights) + 1)
    start = [more, rate, float(heights[-1])]
    if not solver:
        start += [math.sqrt(stiffness / mass - rate**2), 0.0]
    fitted, _ = curve_fit(_critical if solver else _oscillating, times, heights, p0=start)
    off = 100 * (float(fitted[1]) / rate - 1)
    return [{"model": reading.model, "note": run.note, "decay_percent": off} for reading in run.readings]


def _critical(time: FloatArray, size: float, rate: float, end: float) -> FloatArray:
    return np.asarray(end - size * (1 + rate * time) * np.exp(-rate * time))


def _oscillating(time: FloatArray, size: float, rate: float, end: float, speed: float, phase: float) -> FloatArray:
    return np.asarray(end - size * np.exp(-rate * time) * np.cos(speed * time - phase))


def _action_reaction(case: Case) -> list[Row]:
    """Two skins pressed together read the same force."""
    robot, skin = facing_skins(case["skin"])
    ones = np.ones(1)
    push = JointCommand(0 * ones, 0 * ones, 50.0 * ones, 10.0 * ones)
    effects = Effects(
        contact="self",
        gravity="off",
        fingers=False,
        timestep=1e-3 * case["timestep_ms"],
        integrator=case["integrator"],
        skin="water-fill" if case["physics"] == "solver" else case["physics"],
    )
    simulation = Simulation(robot, skin, effects, layer=_COVER)
    simulation.step(500, push)
    loads = simulation.loads
    left = slice(0, int(skin.first[1]))
    readings = (
        {name: model.pressures(loads) for name, model in _models(robot, skin, _COVER).items()}
        if case["physics"] == "solver"
        else {case["physics"]: simulation.sense()}
    )
    rows: list[Row] = []
    for name, pressures in readings.items():
        forces = pressures * skin.areas
        one = float(forces[left].sum())
        other = float(forces[left.stop :].sum())
        balance = abs(one - other) / max(one, other) if max(one, other) > 1.0 else 1.0
        rows.append({"model": name, "note": "", "balance": balance})
    return rows


def _mirror(case: Case) -> list[Row]:
    """Loads at mirrored places have mirrored centres on a regular grid of taxels."""
    shape = case["shape"]
    x, y, z = _place(case["skin"], shape)
    if case["skin"] == "concave":
        x, y = _ASIDE
    signs = [(1.0, 1.0, 0.0), (-1.0, -1.0, 180.0)]  # half a turn of place and body
    if shape in _SYMMETRIC:
        signs.append((-1.0, 1.0, 0.0))
    runs = [_mirrored(case, (across * x, along * y, z), yaw) for across, along, yaw in signs]
    rows: list[Row] = []
    for number, reading in enumerate(runs[0].readings):
        centres = [
            run.readings[number].centre(bench(case["skin"]).taxels)[:2] * (across, along)
            for run, (across, along, _) in zip(runs, signs, strict=True)
        ]
        off = max(float(np.linalg.norm(centre - centres[0])) for centre in centres)
        rows.append({"model": reading.model, "note": runs[0].note, "mirror_mm": 1e3 * off})
    return rows


def _mirrored(case: Case, at: tuple[float, float, float], yaw: float) -> _Run:
    made = bench(case["skin"])
    lab = _Lab(case, made, [lay(case["shape"], at, guided=True, yaw=yaw)], skin=made.taxels)
    lab.run(_SETTLING)
    return lab.watch(0.05)


_CHECKS: Mapping[str, Callable[[Case], list[Row]]] = {
    "rest": _rest,
    "stick": _stick,
    "slip": _slip,
    "impact": _impact,
    "decay": _decay,
    "third law": _action_reaction,
    "mirror": _mirror,
}
CHECKS = tuple(_CHECKS)


def figures(rows: Sequence[Row]) -> list[Figure]:
    """Return no figure: the table is the result."""
    return []


STUDY = Study(
    "contact",
    "Which contacts obey mechanics: weight, centre, rest, friction, impulse, energy, third law and symmetry?",
    "Bodies of 0.5 kg on a fixed block with a flat, convex, concave, half-covered or bare upper side. References are "
    "mechanics alone.",
    cases,
    measure,
    figures,
)
