"""A robot in its skin beside a ball that stands still, led along a path by a controller: its true errors, tick by tick.

``beside_ball`` presses a fixed ball into one taxel of a robot at home. ``run_path`` lets a controller lead the contact
along a path for a round. The controller knows the skin by a calibration, a map, a sensor and an estimator; what counts
is where the object really touches the skin that is there, and how hard. Both come from the simulation's own contacts,
not from any reading.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

import mujoco
import numpy as np
from scipy.spatial import cKDTree

from app.contacts.pipeline import ReadingSettings
from app.control.command import ControlSettings
from app.control.limit_texts import limit_texts
from app.control.limits import Limit, LimitKind
from app.core.arrays import BoolArray, FloatArray, IntArray, freeze_arrays
from app.core.errors import SimulationError, SkinError
from app.geometry.closest_point import ClosestPoint
from app.geometry.mesh import SurfacePoint
from app.maps.paths import draw_path, path_about
from app.maps.tactile_map import TactileMap
from app.robots.kinematics import Configuration
from app.robots.robot import Robot
from app.scene.effects import Effects, SkinModel
from app.scene.object_meshes import make_objects
from app.scene.objects import ObjectSpec
from app.scene.scene_file import scene_for
from app.session.frame import Frame
from app.session.inputs import ControlChanged
from app.session.prepare import PreparedScene, prepare
from app.session.session import Session
from app.simulation.model_assembly import assemble
from app.simulation.model_names import body_name
from app.skin.skin import Patch, Skin
from app.studies.rows import p95, rms
from app.tactile.elastic_layer import ElasticLayer
from app.tactile.sensor_effects import SensorEffects


class TrueContact:
    """Tells how far a contact is from where it is wanted. Built once for a robot, its skin and what is believed of it.

    A misplaced skin has the true one's triangles: the same triangle is the same place. A map learned from touch has
    triangles of its own, between taxels where they truly are: what it calls a place lies where they say.

    Args:
        robot: The robot.
        skin: As it is.
        map_: What is believed.

    Cost: 20 µs a question and patch.
    """

    def __init__(self, robot: Robot, skin: Skin, map_: TactileMap) -> None:
        self._skin, self._believed, self._configuration = skin, map_.skin, Configuration(robot)
        self._nearest = [(patch, ClosestPoint(patch.surface)) for patch in skin.patches]
        self._same = [
            np.array_equal(true.surface.faces, believed.surface.faces)
            for true, believed in zip(skin.patches, map_.skin.patches, strict=True)
        ]

    def error(self, target: SurfacePoint, ball: FloatArray, posture: FloatArray) -> float:
        """From the place of the skin nearest to a ball's middle to where the target lies [m].

        Args:
            target: A place of the believed skin.
            ball: (3,) its middle, world frame [m].
            posture: (joints,) of the robot.
        """
        self._configuration.update(posture)
        skin = self._skin if self._same[target.patch] else self._believed
        wanted = self._configuration.pose(skin.link(target)).points(skin.position(target))
        return float(np.linalg.norm(self.touched(ball) - wanted))

    def touched(self, ball: FloatArray) -> FloatArray:
        """(3,) the place of the skin nearest to a ball's middle (3,), both in the world [m], at the last posture."""
        best = (np.inf, ball)
        for patch, nearest in self._nearest:
            pose = self._configuration.pose(patch.link)
            faces, weights, away = nearest.query(pose.inverse.points(ball)[None])
            if away[0] < best[0]:
                best = (float(away[0]), pose.points(patch.surface.point(int(faces[0]), weights[0])))
        return best[1]


SKIN_LINKS = {"arm": "forearm", "ur5e": "forearm_link", "icub": "l_forearm"}
"""The link of a robot that the skin covers."""
BALL = 0.03
"""Radius [m]."""
DEPTH = 0.001
"""How deep the ball is in the skin at the start [m]."""
MARGIN = 0.02
"""The least way from the ball to the skin's border or to a seam [m], if there is such a place."""
REACH_SHARE = 0.6
"""Share of the best reach that a place needs."""


@dataclass(frozen=True, eq=False)
class PathSetup:
    """All that a course starts from but for the controller's settings. A plain value: it crosses processes.

    Attributes:
        prepared: The truth: robot, skin, map, and a scene with something that touches.
        believed: The map that contacts are read and the arm is controlled by; the true one if None.
        sensor: What the sensor makes of pressures.
        reading: How contacts are read.
    """

    prepared: PreparedScene
    believed: TactileMap | None = None
    sensor: SensorEffects = field(default_factory=SensorEffects)
    reading: ReadingSettings = field(default_factory=ReadingSettings)

    @property
    def map(self) -> TactileMap:
        """The map that is believed."""
        return self.believed or self.prepared.map

    @property
    def effects(self) -> Effects:
        """The scene's, with this sensor."""
        return replace(self.prepared.scene.effects, sensor=self.sensor)

    def session(self, settings: ControlSettings) -> Session:
        """One that simulates the truth, and reads and controls by what is believed."""
        return Session(
            self.prepared,
            scripted=False,
            settings=settings,
            map_=self.believed,
            effects=self.effects,
            reading=self.reading,
        )


@lru_cache(maxsize=4)
def forearm_skin_scene(robot: str, taxels: int, seed: int = 0) -> PreparedScene:
    """A robot of ``SLEEVES`` with skin on its forearm alone. Cost: 4 s at 1500 taxels, kept.

    Raises:
        RobotError: It is not installed.
    """
    scene = scene_for(robot)
    spec = replace(scene.cover, links=(SKIN_LINKS[robot],), taxels=taxels, seed=seed)
    return prepare(replace(scene, cover=spec, stimuli=(), seed=seed))


def beside_ball(
    prepared: PreparedScene,
    *,
    taxel: int | None = None,
    radius: float = BALL,
    depth: float = DEPTH,
    layer: ElasticLayer | None = None,
    model: SkinModel = "foundation",
    tick: float | None = None,
    seed: int | None = None,
) -> PreparedScene:
    """The same robot with a fixed ball pressed into a taxel's place at home, and nothing else around.

    Args:
        prepared: Robot, skin and map; its scene's hand and motion are left out.
        taxel: Where; by default ``place_to_press``.
        radius: Of the ball [m].
        depth: How deep it is pressed in at the start [m].
        layer: The cover; the scene's by default.
        model: How contact becomes pressure. The foundation, which knows no friction, touches the skin itself; the
            solver's contacts touch the convex hull of the link, on real robots some millimetres beside.
        tick: Of control [s]; the scene's by default, as is ``seed``.
        seed: Of what is random in the sensor.

    Raises:
        SkinError: There is no skin to press.
    """
    scene, where = prepared.scene, place_to_press(prepared, radius=radius) if taxel is None else taxel
    x, y, z = points_above(prepared, np.array([where]), radius - depth)[0].tolist()
    cover = layer or scene.layer
    ball = ObjectSpec("ball", "sphere", (radius,), at=(x, y, z), friction=cover.friction)
    alone = replace(scene, objects=(ball,), layer=cover, stimuli=(), motion=(), tick=tick or scene.tick)
    pressed = replace(
        alone,
        task="slide",
        outputs=("force", "pressure"),
        overrides={**scene.overrides, "skin": model},
        seed=scene.seed if seed is None else seed,
    )
    return replace(prepared, scene=pressed, objects=make_objects(pressed))


def points_above(prepared: PreparedScene, taxels: IntArray, height: float) -> FloatArray:
    """(k, 3) the points at a height [m] over ``taxels`` (k,) when the robot is at home [m], world frame."""
    configuration, places = Configuration(prepared.robot), []
    for patch in prepared.skin.patches:
        pose = configuration.pose(patch.link)
        places.append(pose.points(patch.taxels.positions + height * patch.taxels.normals))
    return np.asarray(np.concatenate(places)[taxels])


def place_to_press(prepared: PreparedScene, *, radius: float = BALL) -> int:
    """The taxel that a path is best led around: the flattest that the joints move well, with room around it.

    There is room where border and seams are ``MARGIN`` away on the map, and where a ball is as far from whatever else
    it may touch; where no taxel has as much, those with most are taken. Joints move it well where the least singular
    value of the Jacobian at home is ``REACH`` of the greatest at any of them.

    Args:
        prepared: Robot, skin and map.
        radius: Of the ball [m].

    Raises:
        SkinError: There is no taxel.

    Cost: 0.3 s at 2000 taxels.
    """
    skin, configuration = prepared.skin, Configuration(prepared.robot)
    if not len(skin):
        raise SkinError("there is no skin to press", remedy="Cover a link")
    room = np.concatenate([_margin_on_map(prepared.map, number) for number in range(len(skin.patches))])
    room = np.minimum(room, _margin_to_links(skin, configuration, radius))
    bend = np.concatenate([_curvature(patch) for patch in skin.patches])
    reach = np.array([_least_singular_value(skin, configuration, taxel) for taxel in range(len(skin))])
    roomy = room >= min(MARGIN, float(room.max()))
    good = np.flatnonzero(roomy & (reach >= REACH_SHARE * float(reach[roomy].max())))
    clear = _clearance(prepared, good, radius)
    good = good[clear >= min(MARGIN, float(clear.max()))]
    return int(good[bend[good].argmin()])


def _margin_on_map(map_: TactileMap, patch: int) -> FloatArray:
    """(n,) how far a patch's taxels are from its borders and seams on the map [m]."""
    first, last = map_.skin.first[patch : patch + 2]
    edges = np.concatenate([map_.outlines[patch], map_.seams[patch].reshape(-1, 2)])
    return np.asarray(cKDTree(edges).query(map_.taxel_points[first:last])[0], dtype=np.float64)


def _clearance(prepared: PreparedScene, taxels: IntArray, radius: float) -> FloatArray:
    """(k,) how far a ball over each of ``taxels`` is at home from all shapes that it would touch but skin [m]."""
    beside = beside_ball(prepared, taxel=0, radius=radius)
    model = assemble(beside.robot, beside.skin, beside.scene.effects, objects=beside.objects, layer=beside.scene.layer)
    data, ball = mujoco.MjData(model), model.body(body_name(beside.objects[0].spec))
    data.qpos[:] = beside.robot.home
    touching = (model.geom_contype | model.geom_conaffinity) > 0
    others = np.flatnonzero(touching & (model.geom_bodyid != ball.id)).tolist()
    clear = np.full(len(taxels), MARGIN)
    for number, place in enumerate(points_above(prepared, taxels, radius)):
        model.body_pos[ball.id] = place
        mujoco.mj_kinematics(model, data)
        away = [mujoco.mj_geomDistance(model, data, int(ball.geomadr[0]), geom, MARGIN, None) for geom in others]
        clear[number] = min(away, default=MARGIN)
    return clear


def _margin_to_links(skin: Skin, configuration: Configuration, radius: float) -> FloatArray:
    """(n,) how far a ball over each taxel is at home from the skin of other links [m]."""
    apart = []
    for patch in skin.patches:
        balls = configuration.pose(patch.link).points(patch.taxels.positions + radius * patch.taxels.normals)
        away = np.full(len(balls), np.inf)
        for other in (other for other in skin.patches if other.link != patch.link):
            places = configuration.pose(other.link).inverse.points(balls)
            away = np.minimum(away, ClosestPoint(other.surface).query(places)[2] - radius)
        apart.append(away)
    return np.concatenate(apart)


def _curvature(patch: Patch) -> FloatArray:
    """(n,) the greatest angle between a taxel's normal and those around it, within ``MARGIN`` [rad]."""
    positions, normals = patch.taxels.positions, patch.taxels.normals
    around = cKDTree(positions).query_ball_point(positions, MARGIN)
    least = [float((normals[near] @ normal).min()) for near, normal in zip(around, normals, strict=True)]
    return np.arccos(np.clip(least, -1.0, 1.0))


def _least_singular_value(skin: Skin, configuration: Configuration, taxel: int) -> float:
    """How far the joints move a taxel at least, in the direction in which they move it least [m/rad]."""
    at = skin.taxel_point(taxel)
    moves = configuration.jacobian(skin.link(at), skin.position(at))
    return float(np.linalg.svd(moves, compute_uv=False)[-1]) if moves.shape[1] >= 3 else 0.0


SETTLING = 1.0
"""How long the contact is held at the start of the path before it sets out [s]."""
_SENSED = ("contacts", "control")
"""Stages of a tick that a controller's computer has to do."""


@dataclass(frozen=True, eq=False)
class PathRun:
    """What happened once the contact had set out, tick by tick.

    Attributes:
        tick: [s].
        touching: (k,) whether something touched and the task had a target; where not, the errors are NaN, which their
            statistics leave out.
        body_error: (k,) from where the object truly touches to where the path wants it, on the body [m].
        map_error: (k,) the same as the controller sees it, on its map [m]; NaN also while it sees none.
        force: (k,) that truly presses the skin [N].
        speed: (k,) of the fastest joint [rad/s, or m/s].
        energy: (k,) net energy given to contacts [J].
        finished: How long a round took [s]; None where it was not finished.
        control_ms: What reading and control of one tick take, the median [ms]; None without a tick.
        control_p95_ms: 95 % of the ticks take less [ms]; likewise.
        why_limited: All that limited the controller, the first of each kind, in the order in which they came.
        stopped: Why it ended before its time, for a person: a safety stop, or the physics diverged; empty when not.
    """

    tick: float
    touching: BoolArray
    body_error: FloatArray
    map_error: FloatArray
    force: FloatArray
    speed: FloatArray
    energy: FloatArray
    finished: float | None
    control_ms: float | None
    control_p95_ms: float | None
    why_limited: tuple[Limit, ...] = ()
    stopped: str = ""

    def __post_init__(self) -> None:
        freeze_arrays(self, "body_error", "map_error", "force", "speed", "energy")
        freeze_arrays(self, "touching", dtype=bool)

    @property
    def error_p95(self) -> float | None:
        """95 % of the errors on the body are below [m]; None without contact."""
        return p95(self.body_error)

    @property
    def error_rms(self) -> float | None:
        """Root mean square of the error on the body [m]; None without contact."""
        return rms(self.body_error)

    @property
    def lost(self) -> float:
        """Share of the time without contact."""
        return float((~self.touching).mean()) if len(self.touching) else 1.0

    @property
    def energy_minimum(self) -> float:
        """Of what a passivity observer at the contact counts [J]: below zero by what the arm gave."""
        return float(min(-self.energy.max(initial=0.0), 0.0))

    def in_band(self, goal: float, band: float) -> float:
        """Share of the time with a force within ``band`` of ``goal`` [N]."""
        return float((np.abs(self.force - goal) <= band).mean()) if len(self.force) else 0.0

    def force_p95(self, goal: float) -> float | None:
        """95 % of the force's errors are below [N]; None without a tick."""
        return p95(np.abs(self.force - goal))


def run_path(
    setup: PathSetup, settings: ControlSettings, seconds: float, *, settling: float = SETTLING, rounds: float = 1.0
) -> PathRun:
    """Let the contact settle at the start of the path, then lead it along until the rounds are done.

    Args:
        setup: The truth, and what is believed of it.
        settings: Of the controller; of another task than a path nothing is finished, and it takes all its time.
        seconds: At most, after settling.
        settling: Before the path sets out [s].
        rounds: How often to go along the path; a round of an open one ends at its other end.

    Raises:
        TactileMapsError: The setup cannot be simulated.
    """
    session = setup.session(replace(settings, path_speed=0.0))
    watch = _PathRecorder(session, setup)
    ticks = round(settling / session.prepared.scene.tick)
    try:
        for _ in range(ticks):
            session.tick()
        session.submit(ControlChanged(settings))
        watch.look(settings, seconds, rounds)
    except SimulationError as error:
        watch.stopped = str(error)
    return watch.course()


class _PathRecorder:
    """Looks on. Mutable: rows tick by tick."""

    def __init__(self, session: Session, setup: PathSetup) -> None:
        self._session, self._tick = session, session.prepared.scene.tick
        self._truth = TrueContact(setup.prepared.robot, setup.prepared.skin, setup.map)
        self._rows: list[tuple[float | None, float | None, float, float, float, float]] = []
        self._touching: list[bool] = []
        self._why: dict[LimitKind, Limit] = {}
        self._finished: float | None = None
        self.stopped = ""

    def look(self, settings: ControlSettings, seconds: float, rounds: float) -> None:
        """Tick until the rounds are done or the time is over."""
        done, last = 0.0, self._way
        step = settings.path_speed * self._tick
        for _ in range(round(seconds / self._tick)):
            frame = self._session.tick()
            self._see(frame)
            self.stopped = limit_texts(limit for limit in frame.why_limited if limit.kind.stops)
            if self.stopped:
                return
            # At the end of a closed path the way begins anew.
            done, last = done + min(abs(self._way - last), step), self._way
            if step and done >= rounds * self._length(settings) - step / 2:
                self._finished = len(self._rows) * self._tick
                return

    @property
    def _way(self) -> float:
        task = self._session.frame.task
        return task.way if task is not None else 0.0

    def _length(self, settings: ControlSettings) -> float:
        """Of the path [m]; endless until it is laid."""
        task = self._session.frame.task
        if settings.task != "follow_path":
            return float("inf")
        if len(settings.path) > 1:
            return draw_path(settings.path_kind, settings.path).length
        if task is None or task.laid_at is None:
            return float("inf")
        return path_about(settings.path_kind, np.array(task.laid_at), settings.path_size).length

    def _see(self, frame: Frame) -> None:
        task, force = frame.task, self._session.total_normal_force
        body = on_map = None
        if task is not None and task.target is not None and force > 0:
            body = self._truth.error(task.target, frame.objects[0, :3, 3], frame.posture)
            on_map = task.error
        ms = sum(frame.timings.ms.get(stage, 0.0) for stage in _SENSED)
        fastest = float(np.abs(frame.velocity).max(initial=0.0))
        self._touching.append(body is not None)
        self._rows.append((body, on_map, force, fastest, task.energy if task else 0.0, ms))
        for limit in frame.why_limited:
            self._why.setdefault(limit.kind, limit)

    def course(self) -> PathRun:
        """All of it."""
        body, on_map, force, speed, energy, ms = np.array(self._rows, dtype=np.float64).reshape(-1, 6).T
        return PathRun(
            self._tick,
            np.array(self._touching, dtype=np.bool_),
            body,
            on_map,
            force,
            speed,
            energy,
            self._finished,
            control_ms=float(np.median(ms)) if len(ms) else None,
            control_p95_ms=p95(ms),
            why_limited=tuple(self._why.values()),
            stopped=self.stopped,
        )
