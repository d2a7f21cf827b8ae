"""A robot next to a fixed ball, a controller that moves the contact along a path, and the true errors at each tick.

The controller knows the skin through a calibration, a map, a sensor and an estimator. Errors are measured at the true
contact of the object with the true skin, from the contacts of the simulation instead of any reading.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.limit_texts import limit_texts
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray
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
    """Measures the distance of a contact from its target. Built once for a robot, its skin and a believed map.

    A misplaced skin has the triangles of the true one, so that a place has the same coordinates. A map learned from
    touch has its own triangles between the true places of the taxels, which define its places.

    Args:
        robot: The robot.
        skin: The true skin.
        map_: The believed map.

    Cost: 20 µs a query and patch.
    """

    def __init__(self, robot: Robot, skin: Skin, map_: TactileMap) -> None:
        self._skin = skin
        self._believed = map_.skin
        self._configuration = Configuration(robot)
        self._nearest = [(patch, ClosestPoint(patch.surface)) for patch in skin.patches]
        self._same = list(map(same_triangles, skin.patches, map_.skin.patches))

    def error(self, target: SurfacePoint, ball: FloatArray, posture: FloatArray) -> float:
        """Return the distance from the place of the skin nearest to the centre of a ball to the target [m].

        Args:
            target: Place on the believed skin.
            ball: (3,) centre of the ball, world frame [m].
            posture: (joints,) posture of the robot.
        """
        self._configuration.update(posture)
        skin = self._skin if self._same[target.patch] else self._believed
        goal = self._configuration.pose(skin.link(target)).points(skin.position(target))
        return float(np.linalg.norm(self.touched(ball) - goal))

    def touched(self, ball: FloatArray) -> FloatArray:
        """Return the place (3,) of the skin nearest to the centre of a ball (3,), last posture, world frame [m]."""
        best = (np.inf, ball)
        for patch, nearest in self._nearest:
            pose = self._configuration.pose(patch.link)
            faces, weights, away = nearest.query(pose.inverse.points(ball)[None])
            if away[0] < best[0]:
                best = (float(away[0]), pose.points(patch.surface.point(int(faces[0]), weights[0])))
        return best[1]


@dataclass(frozen=True, eq=False)
class PathSetup:
    """Everything that a run starts from except the settings of the controller; can be sent to other processes.

    Attributes:
        prepared: Truth: robot, skin, map, and a scene with an object in contact.
        believed: Map for reading contacts and for control; None for the true one.
        sensor: Effects of the sensor.
        reading: Settings of contact reading.
        pressed_elsewhere: Force of other contacts [N], which is not that of the path.
    """

    prepared: PreparedScene
    believed: TactileMap | None = None
    sensor: SensorEffects = field(default_factory=SensorEffects)
    reading: ReadingSettings = field(default_factory=ReadingSettings)
    pressed_elsewhere: float = 0.0

    @property
    def map(self) -> TactileMap:
        """The believed map."""
        return self.believed or self.prepared.map

    @property
    def effects(self) -> Effects:
        """Effects of the scene, with this sensor."""
        return replace(self.prepared.scene.effects, sensor=self.sensor)

    def session(self, settings: ControlSettings) -> Session:
        """Return a session that simulates the truth, and reads and controls by the believed map."""
        return Session(
            self.prepared,
            scripted=False,
            settings=settings,
            map_=self.believed,
            effects=self.effects,
            reading=self.reading,
        )


SETTLING = 1.0
"""Time for which the contact is held at the start of the path before it moves [s]."""
_SENSED = ("contacts", "control")
"""Stages of a tick that run on the computer of a controller."""


@dataclass(frozen=True, eq=False)
class PathRun(ArrayFields):
    """Course of a run at each tick, after the contact started to move.

    Attributes:
        tick: Duration of a tick [s].
        touching: (k,) whether there was a contact and a target; otherwise errors are NaN and left out of statistics.
        body_error: (k,) distance from the true contact to the target of the path, on the body [m].
        map_error: (k,) the same as the controller sees it, on its map [m]; NaN also while it sees no contact.
        force: (k,) true force on the skin [N].
        speed: (k,) speed of the fastest joint [rad/s, or m/s].
        energy: (k,) net energy given to contacts [J].
        finished: Duration of a round [s]; None for an unfinished one.
        control_ms: Median time of reading and control in a tick [ms]; None without a tick.
        control_p95_ms: 95th percentile of that time [ms]; None without a tick.
        why_limited: All limits of the controller, the first of each kind, in order of occurrence.
        stopped: Reason of an early end (safety stop or divergence), for people; empty without one.
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

    @property
    def error_p95(self) -> float | None:
        """95th percentile of the errors on the body [m]; None without contact."""
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
        """Minimum energy of a passivity observer at the contact [J]: negative if the arm gave energy."""
        return float(min(-self.energy.max(initial=0.0), 0.0))

    def in_band(self, goal: float, band: float) -> float:
        """Return the share of the time with a force within ``band`` of ``goal`` [N]."""
        return float((np.abs(self.force - goal) <= band).mean()) if len(self.force) else 0.0

    def force_p95(self, goal: float) -> float | None:
        """Return the 95th percentile of the errors of the force [N]; None without a tick."""
        return p95(np.abs(self.force - goal))


def run_path(setup: PathSetup, settings: ControlSettings, seconds: float, *, settling: float = SETTLING) -> PathRun:
    """Let the contact settle at the start of the path, then lead it along the path for a round.

    Args:
        setup: Truth and belief.
        settings: Settings of the controller; a task without a path is never finished and uses all of the time.
        seconds: Maximum time after settling. A round of an open path ends at its other end.
        settling: Time before the contact moves [s].

    Raises:
        TactileMapsError: The setup cannot be simulated.
    """
    session = setup.session(replace(settings, path_speed=0.0))
    recorder = _PathRecorder(session, setup)
    ticks = round(settling / session.prepared.scene.tick)
    try:
        for _ in range(ticks):
            session.tick()
        session.submit(ControlChanged(settings))
        recorder.follow(settings, seconds)
    except SimulationError as error:
        recorder.stopped = str(error)
    return recorder.run()


class _PathRecorder:
    """Recorder of a run. Mutable: one row for each tick."""

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

    def follow(self, settings: ControlSettings, seconds: float) -> None:
        """Tick until a round is finished or the time is over."""
        done = 0.0
        last = self._way
        step = settings.path_speed * self._tick
        for _ in range(round(seconds / self._tick)):
            frame = self._session.tick()
            self._record(frame)
            self.stopped = limit_texts(limit for limit in frame.why_limited if limit.kind.stops)
            if self.stopped:
                return
            # The path parameter restarts at the end of a closed path.
            done = done + min(abs(self._way - last), step)
            last = self._way
            if step and done >= self._length(settings) - step / 2:
                self._finished = len(self._rows) * self._tick
                return

    @property
    def _way(self) -> float:
        task = self._session.frame.task
        return task.way if task is not None else 0.0

    def _length(self, settings: ControlSettings) -> float:
        """Length of the path [m]; infinite before the path is placed."""
        task = self._session.frame.task
        if settings.task != "follow_path":
            return float("inf")
        if len(settings.path) > 1:
            return draw_path(settings.path_kind, settings.path).length
        if task is None or task.laid_at is None:
            return float("inf")
        return path_about(settings.path_kind, np.array(task.laid_at), settings.path_size).length

    def _record(self, frame: Frame) -> None:
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

    def run(self) -> PathRun:
        """Return the recorded run."""
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
