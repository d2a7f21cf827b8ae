"""A robot in its skin beside a ball that stands still, led along a path by a controller: its true errors, tick by tick.

``run_path`` lets a controller lead the contact
along a path for a round. The controller knows the skin by a calibration, a map, a sensor and an estimator; what counts
is where the object really touches the skin that is there, and how hard. Both come from the simulation's own contacts,
not from any reading.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.limit_texts import limit_texts
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.core.arrays import BoolArray, FloatArray, freeze_arrays
from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.paths import draw_path, path_about
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.session.frame import Frame
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session
from tactile_maps.skin.model.skin import Skin, same_triangles
from tactile_maps.studies.base.rows import p95, rms
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects


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
        self._skin = skin
        self._believed = map_.skin
        self._configuration = Configuration(robot)
        self._nearest = [(patch, ClosestPoint(patch.surface)) for patch in skin.patches]
        self._same = list(map(same_triangles, skin.patches, map_.skin.patches))

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


@dataclass(frozen=True, eq=False)
class PathSetup:
    """All that a course starts from but for the controller's settings. A plain value: it crosses processes.

    Attributes:
        prepared: The truth: robot, skin, map, and a scene with something that touches.
        believed: The map that contacts are read and the arm is controlled by; the true one if None.
        sensor: What the sensor makes of pressures.
        reading: How contacts are read.
        pressed_elsewhere: Force of whatever else presses the skin [N], which is not the path's.
    """

    prepared: PreparedScene
    believed: TactileMap | None = None
    sensor: SensorEffects = field(default_factory=SensorEffects)
    reading: ReadingSettings = field(default_factory=ReadingSettings)
    pressed_elsewhere: float = 0.0

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
        self._session = session
        self._tick = session.prepared.scene.tick
        self._elsewhere = setup.pressed_elsewhere
        self._truth = TrueContact(setup.prepared.robot, setup.prepared.skin, setup.map)
        self._rows: list[tuple[float | None, float | None, float, float, float, float]] = []
        self._touching: list[bool] = []
        self._why: dict[LimitKind, Limit] = {}
        self._finished: float | None = None
        self.stopped = ""

    def look(self, settings: ControlSettings, seconds: float, rounds: float) -> None:
        """Tick until the rounds are done or the time is over."""
        done = 0.0
        last = self._way
        step = settings.path_speed * self._tick
        for _ in range(round(seconds / self._tick)):
            frame = self._session.tick()
            self._see(frame)
            self.stopped = limit_texts(limit for limit in frame.why_limited if limit.kind.stops)
            if self.stopped:
                return
            # At the end of a closed path the way begins anew.
            done = done + min(abs(self._way - last), step)
            last = self._way
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
        task = frame.task
        force = max(self._session.total_normal_force - self._elsewhere, 0.0)
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
