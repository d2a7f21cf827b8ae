"""Trial of a controller on a robot, evaluated with true quantities of the simulation.

A fixed ball presses the skin at the start with about 1 N, at the place that ``place_to_press`` chooses: flat, with room
around it, and well moved by the joints. Other places are not tried. ``press`` keeps 3 N, ``path`` leads the contact
along a figure of eight at 10 mm/s, and in ``pushed`` the ball moves into the skin until a motor of 60 N holds it.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, TypeAlias

import mujoco
import numpy as np
from scipy.optimize import least_squares

from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import MAX_JOINT_SPEED, posture_loop
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.paths import path_about
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.mujoco_spec import compile_spec, robot_spec
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session
from tactile_maps.simulation.model.model_names import body_name
from tactile_maps.studies.testbeds.fixed_ball import place_to_press, points_above, with_fixed_ball
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.sensors.sensor_effects import Sampling

Posture: TypeAlias = Literal["home", "bent", "near limits", "near singular"]
Task: TypeAlias = Literal["press", "path", "pushed"]
POSTURES: tuple[Posture, ...] = ("home", "bent", "near limits", "near singular")
STIFFNESSES = (1e3, 1e4, 1e5)
"""Stiffness of the contact [N/m]."""
RATES = (200.0, 50.0)
"""Readings of the skin per second [Hz]; at 50 Hz they arrive 20 ms late."""
FOLLOWERS = tuple(name for name in CONTROL_SCHEMES if name != "hold_force")
CONTROLLERS: dict[Task, tuple[str, ...]] = {
    "press": ("hold_force", *FOLLOWERS),
    "path": FOLLOWERS,
    "pushed": ("impedance", "hold_force", *FOLLOWERS),
}
"""Controllers for which a task is defined."""
GOAL = 3.0
"""Requested force [N]."""
WITHIN = 0.15
"""Largest error of the mean force in the last second [N]."""
RIPPLE = 0.3
"""Peak to peak of the force in the last second, in contact, above which the loop is in a limit cycle [N]."""
PATH_WITHIN = 0.003
"""95 % quantile of the distance from the contact to its target [m]."""
TILT = np.deg2rad(15)
"""Smallest angle between the skin and the motion of its points for which force control is promised [rad]."""
OVERLOAD = 0.02
"""Longest time above the greatest force from the moment that a reading can report it [s]."""
_HOLLOW = 1e-3
"""Largest depth of another place of the same link in a ball that touches a place of a path [m]."""
_DEPTHS = (0.0, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 0.016)
"""Depths at which the ball is looked for on the shapes that collide [m]."""
_HEIGHTS = (0.002, 0.004, 0.008, 0.016)
"""Heights above which it is looked for; in a hollow, a ball that touches the taxel is in the skin around it [m]."""
_SECONDS: dict[Task, float] = {"press": 4.0, "path": 10.0, "pushed": 2.5}
"""Duration of a trial; four more for a press at 50 Hz [s]."""
_SETTLED = 2.5
"""Start of the judgement of a path [s]."""
_PATH_SPEED = 0.01
"""Speed at which controllers follow a path by default [m/s]."""
_KEPT = 0.9
"""Share of the time in contact from which inaccurate readings of the place may explain an error."""
_SWING = 3.0
"""Peak to peak of the force above which a path that misses its bound counts as a limit cycle [N]."""
_AT_LIMIT = 0.05
"""A joint that is named as being at its limit is closer to it than this share of its range or 0.1 rad (a loaded joint
yields by so much), and as the reason of a refusal closer than 0.02 rad."""
_READ_WITHIN = 0.1
"""Largest relative error of a force reading that a stop by force may have."""
_LEAST_FELT = 0.3
"""A contact that is reported as lost has less force than this, or no taxel reports it [N]."""


NO_PLACE = "no place"
"""Verdict where no trial was possible."""


@dataclass(frozen=True)
class Trial:
    """A cell of the grid of trials."""

    posture: Posture
    stiffness: float
    rate: float
    controller: str
    task: Task

    @property
    def delay(self) -> float:
        """Age of the newest reading just before the next one [s]: at 50 Hz it arrives 20 ms late and lasts 20 ms."""
        return 0.0 if self.rate >= RATES[0] else 0.04

    def __str__(self) -> str:
        return f"{self.task} {self.posture} {self.stiffness:g} N/m {self.rate:g} Hz {self.controller}"


@dataclass(frozen=True)
class Outcome:
    """Result of a trial; forces and motion are those of the simulation.

    Attributes:
        verdict: ``ok``, ``refused`` (with a true reason), ``failed``, or ``NO_PLACE``.
        cause: Reason of a refusal or failure.
        tilt_deg: Angle between the skin and the motion by which the joints press most [deg].
        force: Mean force in the last second [N].
        ripple: Peak to peak of the force in the last second [N].
        peak: Greatest force [N].
        overload_ms: Longest time in which one contact has more than the greatest allowed force [ms].
        error_mm: 95 % quantile of the distance from the contact to its target [mm]; None without one.
        way_mm: Length of the path that was covered [mm].
        limits: Kinds of limits in the second half of the trial, the most frequent first.
    """

    verdict: str
    cause: str
    tilt_deg: float
    force: float
    ripple: float
    peak: float
    overload_ms: float
    error_mm: float | None
    way_mm: float
    limits: str


def grid(task: Task, *, turn: int = 0) -> list[Trial]:
    """Return all trials of a task.

    The first 24 have every posture with every stiffness and rate, and any first ones have them about equally often,
    with controllers that take turns.

    Args:
        task: The task.
        turn: The controller to begin with, so that robots with few trials have different ones.
    """
    names = CONTROLLERS[task]
    trials = list[Trial]()
    conditions = len(POSTURES) * len(STIFFNESSES) * len(RATES)
    for k in range(conditions * len(names)):
        mixed = k + k // len(POSTURES)
        trials.append(
            Trial(
                POSTURES[k % len(POSTURES)],
                STIFFNESSES[mixed % len(STIFFNESSES)],
                RATES[mixed % len(RATES)],
                names[(turn + k + k // conditions) % len(names)],
                task,
            )
        )
    return trials


def posture_of(prepared: PreparedScene, name: Posture, seed: int = 0) -> FloatArray | None:
    """Return a posture (n,) [rad, m] at which the robot touches itself no more than at home; None if none is found.

    ``bent``: random within 15 to 85 % of each range, at most 2.5 rad. ``near limits``: every joint 3 % of its range
    from one of its limits. ``near singular``: of random postures, the one at which the joints move the skin least
    evenly.
    """
    robot = prepared.robot
    if name == "home":
        return robot.home
    rng = np.random.default_rng(seed)
    lower = np.array([max(joint.lower, -2.5) for joint in robot.joints])
    upper = np.array([min(joint.upper, 2.5) for joint in robot.joints])
    free = _Free(robot)
    found: list[FloatArray] = []
    for _ in range(300):
        if name == "near limits":
            share = np.where(rng.random(len(lower)) < 0.5, 0.03, 0.97)
        else:
            share = 0.15 + 0.7 * rng.random(len(lower))
        posture = lower + share * (upper - lower)
        if free.at(posture):
            found.append(posture)
        if found and (name != "near singular" or len(found) == 60):
            break
    if not found:
        return None
    return found[0] if name != "near singular" else min(found, key=lambda posture: _evenness(prepared, posture))


class _Free:
    """Predicate for postures in which the robot touches itself no more than at home."""

    def __init__(self, robot: Robot) -> None:
        self._model = compile_spec(robot_spec(robot), source=robot.source)
        self._data = mujoco.MjData(self._model)
        self._allowed = self._pairs(robot.home)

    def _pairs(self, posture: FloatArray) -> set[tuple[int, ...]]:
        self._data.qpos[:] = posture
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        geoms = self._data.contact.geom[self._data.contact.dist <= 0]
        return {tuple(sorted(pair)) for pair in self._model.geom_bodyid[geoms].reshape(-1, 2).tolist()}

    def at(self, posture: FloatArray) -> bool:
        return self._pairs(posture) <= self._allowed


def _evenness(prepared: PreparedScene, posture: FloatArray) -> float:
    """Return the least over the greatest singular value of the motion of the skin's best link."""
    configuration = Configuration(prepared.robot)
    configuration.update(posture)
    ratios = []
    for patch in prepared.skin.patches:
        moves = configuration.jacobian(patch.link, patch.taxels.positions.mean(axis=0))
        values = np.linalg.svd(moves, compute_uv=False)
        ratios.append(values[2] / values[0] if moves.shape[1] >= 3 and values[0] > 0 else 0.0)
    return float(max(ratios))


def at_posture(prepared: PreparedScene, posture: FloatArray) -> PreparedScene:
    """Return the robot with another home posture."""
    return replace(prepared, robot=replace(prepared.robot, home=posture))


def tilt(configuration: Configuration, link: str, position: FloatArray, normal: FloatArray) -> float:
    """Return the angle between the skin and the motion by which the joints press most at a point [rad].

    Args:
        configuration: The robot at a posture.
        link: Link of the point.
        position: (3,) the point, link frame [m].
        normal: (3,) outward unit normal, link frame.
    """
    move = configuration.jacobian(link, position)
    outward = configuration.pose(link).rotation @ normal
    way = move @ (move.T @ outward)
    return float(np.arcsin(np.clip(outward @ way / max(float(np.linalg.norm(way)), 1e-12), 0.0, 1.0)))


def ball_radius(prepared: PreparedScene) -> float:
    """Return a radius that suits the size of the links with skin [m]."""
    widths = [float(np.median(np.ptp(patch.surface.vertices, axis=0))) for patch in prepared.skin.patches]
    return float(np.clip(0.75 * min(widths), 0.004, 0.03))


class Place:
    """Contact of a robot at a posture: the taxel, the ball and the size of a path around it."""

    def __init__(self, prepared: PreparedScene) -> None:
        skin = prepared.skin
        self.prepared = prepared
        self.radius = ball_radius(prepared)
        self.taxel = place_to_press(prepared, radius=self.radius)
        at = skin.taxel_point(self.taxel)
        self.patch = at.patch
        self.link = skin.link(at)
        self.tilt = tilt(Configuration(prepared.robot), self.link, skin.position(at), skin.normal(at))
        centre = prepared.map.taxel_points[self.taxel]
        sizes = (0.03, 0.02, 0.014, 0.01, 0.007, 0.005)
        self.path_size = next((size for size in sizes if self._fits(centre, size)), sizes[-1])

    def _fits(self, centre: FloatArray, size: float) -> bool:
        """Return whether a path is on the skin, and the ball can touch each of its places on this link alone."""
        skin = self.prepared.skin
        closest = ClosestPoint(skin.patches[self.patch].surface)
        places = [self.prepared.map.to_body(point) for point in path_about("lemniscate", centre, 1.3 * size).points]
        if None in places:
            return False
        here = [at for at in places if at is not None and at.patch == self.patch]
        centres = np.array([skin.position(at) + self.radius * skin.normal(at) for at in here])
        return bool((closest.query(centres)[2] > self.radius - _HOLLOW).all())

    def session(self, trial: Trial) -> Session:
        """Return the session of a trial; the ball presses with about 1 N once the arm has yielded to it."""
        layer = replace(self.prepared.scene.layer, stiffness=trial.stiffness)
        depth = min(1.0 / trial.stiffness + self._compliance, GOAL / trial.stiffness)
        scene = self.with_ball(layer, depth=self.gap + depth)
        if trial.task == "pushed":
            scene = _pushing(scene, self.outward)
        settings = ControlSettings(
            controller=trial.controller,
            task="follow_path" if trial.task == "path" else "keep_force",
            path_size=self.path_size,
        )
        session = Session(scene, settings=settings)
        if trial.rate >= RATES[0]:
            return session
        sensor = replace(session.effects.sensor, sampling=Sampling(trial.rate, 0.02))
        return Session(scene, settings=settings, effects=replace(session.effects, sensor=sensor))

    def with_ball(self, layer: ElasticLayer, depth: float) -> PreparedScene:
        """Return the robot with the fixed ball in the skin by ``depth`` [m]."""
        return with_fixed_ball(
            self.prepared, taxel=self.taxel, radius=self.radius, model="water-fill", layer=layer, depth=depth
        )

    @property
    def _compliance(self) -> float:
        """Return the way by which the skin yields to 1 N along its normal [m], by the joints' stiff impedance."""
        configuration = Configuration(self.prepared.robot)
        stiffness = posture_loop(configuration).stiffness
        at = self.prepared.skin.taxel_point(self.taxel)
        row = self.outward @ configuration.jacobian(self.link, self.prepared.skin.position(at))
        return float((row**2 / stiffness).sum())

    @cached_property
    def gap(self) -> float:
        """Distance from the ball to the shapes by which the robot collides, when it touches the taxel [m].

        Found by bisection with the simulation's own force: shapes of hollow links are in pieces, whose contacts are
        corrected.
        """
        session = Session(self.with_ball(self.prepared.scene.layer, depth=0.0))
        model = session._simulation._model
        ball = model.body(body_name(session.prepared.objects[0].spec)).id
        start = model.body_pos[ball].copy()

        def touches(depth: float) -> bool:
            model.body_pos[ball] = start - depth * self.outward
            session.reset()
            session.tick()
            return session.total_normal_force > 0

        deep = next((depth for depth in _DEPTHS if touches(depth)), None)
        apart = next((-height for height in _HEIGHTS if not touches(-height)), None)
        if deep is None or apart is None:
            raise SkinError("the ball cannot touch the skin here", place=self.link, value=self.taxel)
        while deep - apart > 2e-6:
            middle = 0.5 * (apart + deep)
            apart, deep = (apart, middle) if touches(middle) else (middle, deep)
        return deep

    @property
    def outward(self) -> FloatArray:
        """Return the outward unit normal (3,) of the skin at the place, world frame."""
        ends = [points_above(self.prepared, np.array([self.taxel]), height)[0] for height in (0.0, 1.0)]
        return np.asarray(ends[1] - ends[0])


def _pushing(scene: PreparedScene, outward: FloatArray) -> PreparedScene:
    """Return the scene whose ball moves 0.1 m into the skin at 0.1 m/s, pushed with 60 N at most."""
    (ball,) = scene.scene.objects
    start = np.array(ball.at)
    ways = [(0.0, start), (0.3, start), (1.3, start - 0.1 * outward), (60.0, start - 0.1 * outward)]
    path = tuple((time, *map(float, at)) for time, at in ways)
    probe = replace(ball, kind="probe", mass=0.2, max_force=60.0, path=path)
    pushing = replace(scene.scene, objects=(probe,))
    return replace(scene, scene=pushing, objects=make_objects(pushing))


class _Course:
    """True quantities of a session, tick by tick."""

    def __init__(self, session: Session, place: Place, trial: Trial, seconds: float) -> None:
        self.session = session
        self.place = place
        self.trial = trial
        self.tick = session.prepared.scene.tick
        self.max_force = session.settings.max_force
        count = round(seconds / self.tick)
        self.force, self.strongest, self.speed, self.way, self.pressure = np.zeros((5, count))
        self.walked = 0.0
        self.error, self.misread = np.full((2, count), np.nan)
        self.limits: list[tuple[Limit, ...]] = []
        self.false: Counter[str] = Counter()
        self.refusals: Counter[str] = Counter()
        self._configuration = Configuration(session.prepared.robot)
        self._skin = session.prepared.skin
        self._patch = place.patch
        self._closest = ClosestPoint(self._skin.patches[place.patch].surface)
        self.least_tilt = place.tilt
        self.sunk = False
        for k in range(count):
            self._look(k)

    def _look(self, k: int) -> None:
        frame = self.session.tick()
        self.force[k] = self.session.total_normal_force
        self.strongest[k] = self._strongest(frame)
        self.speed[k] = np.abs(frame.velocity).max(initial=0.0)
        self.pressure[k] = frame.pressures.max()
        self.limits.append(frame.why_limited)
        target = None
        if frame.task is not None:
            self.way[k] = frame.task.way
            target = frame.task.target
            step = self.way[k] - self.way[k - 1] if k else 0.0
            self.walked += step if step > 0 else 0.0  # a closed path begins again at zero
        if k % 5 == 0 and self.force[k] > 0:
            self._configuration.update(frame.posture)
            position, normal = self._contact(frame.objects[0][:3, 3])
            self.least_tilt = min(self.least_tilt, tilt(self._configuration, self.place.link, position, normal))
            centre = self._configuration.pose(self.place.link).inverse.points(frame.objects[0][:3, 3])
            self.sunk |= bool((centre - position) @ normal < 0)
            if target is not None and self.session.map.skin.link(target) == self.place.link:
                self.error[k] = np.linalg.norm(self.session.map.skin.position(target) - position)
            read = [region.link_position for region in frame.regions if region.link == self.place.link]
            self.misread[k] = min((np.linalg.norm(at - position) for at in read), default=np.nan)
        for limit in frame.why_limited:
            if not self._is_true(k, limit, frame.posture, target):
                self.false[limit.kind.value] += 1
            elif k % 5 == 0 and self._binds(limit, frame.posture):
                self.refusals[limit.kind.value] += 1

    def _strongest(self, frame: Frame) -> float:
        """Return the largest force of one contact [N]: each true load counts to the nearest contact that is read."""
        forces = Counter[int | str]()
        for load in self.session._simulation.loads:
            read = [one for one in frame.regions if one.link == load.link]
            near = ((float(np.linalg.norm(one.link_position - load.point)), one.id) for one in read)
            forces[min(near, default=(0.0, load.link))[1]] += load.force
        return max(forces.values(), default=0.0)

    def _contact(self, ball: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the place of the skin nearest to the ball's centre (3,) and its normal (3,), link frame."""
        centre = self._configuration.pose(self.place.link).inverse.points(ball)
        faces, weights, _ = self._closest.query(centre[None])
        at = SurfacePoint(self._patch, int(faces[0]), tuple(map(float, weights[0])))
        return self._skin.position(at), self._skin.normal(at)

    def _recent(self, values: np.ndarray, k: int, seconds: float) -> np.ndarray:
        return values[max(0, k + 1 - round(seconds / self.tick)) : k + 1]

    def _is_true(self, k: int, limit: Limit, posture: FloatArray, target: SurfacePoint | None) -> bool:
        """Return whether the simulation is as a limit states; limits that state no fact of the world are true."""
        begins = k == 0 or limit.kind not in {earlier.kind for earlier in self.limits[k - 1]}
        recent = 0.05 + self.trial.delay
        match limit.kind:
            case LimitKind.STOPPED_BY_FORCE:
                least = (1 - _READ_WITHIN) * self.max_force
                return not begins or self._recent(self.force, k, recent).max() > least
            case LimitKind.STOPPED_BY_UNMEASURED_FORCE:  # the ball is all that touches the robot
                return not begins or self._recent(self.force, k, recent).max() > self.max_force
            case LimitKind.STOPPED_BY_SPEED:
                return not begins or limit.bound is None or self._recent(self.speed, k, 0.02).max() > limit.bound
            case LimitKind.STOPPED_UNREADABLE | LimitKind.STOPPED_BY_MISMATCH | LimitKind.SKIN_SATURATED:
                return False  # one contact, and every reading is a number within the range
            case LimitKind.CONTACT_LOST:
                unfelt = self._recent(self.pressure, k, recent).min() < self.session._contacts.threshold
                return not begins or unfelt or self._recent(self.force, k, recent).min() < _LEAST_FELT
            case LimitKind.OSCILLATION:
                return not begins or float(np.ptp(self._recent(self.force, k, 4.0))) > RIPPLE
            case LimitKind.FORCE_RISES:
                return not begins or self.least_tilt < TILT + np.deg2rad(5)
            case LimitKind.JOINT_LIMIT:
                return self._at_limits(limit, posture, 0.1, share=_AT_LIMIT)
            case LimitKind.OUT_OF_REACH:
                return not begins or target is None or not self._reaches(target, posture)
            case _:
                return True

    def _binds(self, limit: Limit, posture: FloatArray) -> bool:
        """Return whether a limit makes the task impossible, by other means than those of the controller."""
        match limit.kind:
            case LimitKind.PLACE_UNCERTAIN:
                return (quantile(self.misread) or 0.0) > PATH_WITHIN
            case LimitKind.OUT_OF_REACH:
                return True  # see _is_true
            case LimitKind.JOINT_LIMIT:
                return self._at_limits(limit, posture, 0.02)
            case LimitKind.FORCE_RISES | LimitKind.CONTACT_IMMOBILE:
                return self.least_tilt < TILT
            case LimitKind.WEAK_DIRECTION:
                return self.least_tilt < TILT or self._most_speed(limit, posture) < _PATH_SPEED
            case _:
                return False

    def _at_limits(self, limit: Limit, posture: FloatArray, angle: float, *, share: float = 0.0) -> bool:
        """Return whether all joints that a limit names are closer to a limit than an angle or share of their range."""
        joints = {joint.name: (joint, q) for joint, q in zip(self.session.prepared.robot.joints, posture, strict=True)}
        return all(
            min(q - joint.lower, joint.upper - q) < max(angle, share * (joint.upper - joint.lower))
            for joint, q in map(joints.__getitem__, limit.names)
        )

    def _most_speed(self, limit: Limit, posture: FloatArray) -> float:
        """Return the speed of the touched point in the direction that a limit names, all joints at their fastest."""
        if limit.direction is None:
            return np.inf
        self._configuration.update(posture)
        position, _ = self._contact(self.session.frame.objects[0][:3, 3])
        move = self._configuration.jacobian(self.place.link, position)
        speeds = [joint.max_speed for joint in self.session.prepared.robot.joints]
        return float(np.abs(np.array(limit.direction) @ move) @ np.minimum(speeds, MAX_JOINT_SPEED))

    def _reaches(self, target: SurfacePoint, posture: FloatArray) -> bool:
        """Return whether a posture near the current one brings a place of the skin to the ball, facing its centre."""
        robot = self.session.prepared.robot
        skin = self.session.map.skin
        link = skin.link(target)
        out = skin.position(target) + self.place.radius * skin.normal(target)
        ball = self.session.frame.objects[0][:3, 3]

        def miss(q: FloatArray) -> FloatArray:
            self._configuration.update(q)
            return np.asarray(self._configuration.pose(link).points(out) - ball)

        lower = np.array([joint.lower for joint in robot.joints])
        upper = np.array([joint.upper for joint in robot.joints])
        rng = np.random.default_rng(1)
        starts = [posture, *(posture + rng.uniform(-0.3, 0.3, (6, len(posture))))]
        starts = [np.clip(start, lower + 1e-9, upper - 1e-9) for start in starts]
        misses = (least_squares(miss, start, bounds=(lower, upper), max_nfev=50).fun for start in starts)
        return any(np.linalg.norm(off) < 1e-3 for off in misses)

    def last(self, values: np.ndarray, seconds: float = 1.0) -> np.ndarray:
        return values[-round(seconds / self.tick) :]

    def overload(self) -> float:
        """Return the longest time in which the force of one contact is above the greatest allowed one [s]."""
        longest = 0
        count = 0
        for above in self.strongest > self.max_force:
            count = count + 1 if above else 0
            longest = max(longest, count)
        return longest * self.tick


def quantile(errors: FloatArray) -> float | None:
    """Return the 95 % quantile of the known errors (k,), those that are numbers; None without any."""
    known = errors[np.isfinite(errors)]
    return float(np.quantile(known, 0.95)) if len(known) else None


def run(place: Place, trial: Trial, *, seconds: float | None = None) -> Outcome:
    """Run a trial and judge it, by default after the duration of its task; ``seconds`` is another one [s]."""
    if seconds is None:
        seconds = _SECONDS[trial.task] + (4.0 if trial.task == "press" and trial.rate < RATES[0] else 0.0)
    course = _Course(place.session(trial), place, trial, seconds)
    last = course.last(course.force)
    kinds = Counter(limit.kind.value for found in course.limits[len(course.limits) // 2 :] for limit in found)
    error = quantile(course.error[round(_SETTLED / course.tick) :]) if trial.task == "path" else None
    verdict, cause = _verdict(course, error)
    return Outcome(
        verdict=verdict,
        cause=cause,
        tilt_deg=float(np.rad2deg(course.least_tilt)),
        force=float(last.mean()),
        ripple=float(np.ptp(last)),
        peak=float(course.force.max()),
        overload_ms=1e3 * course.overload(),
        error_mm=None if error is None else 1e3 * error,
        way_mm=1e3 * float(course.walked),
        limits=" ".join(f"{kind}:{count}" for kind, count in kinds.most_common()),
    )


def _verdict(course: _Course, error: float | None) -> tuple[str, str]:
    if course.sunk:
        return NO_PLACE, f"the ball sinks into the link up to its centre at {course.trial.stiffness:g} N/m"
    if course.false:
        return "failed", f"not true: {', '.join(course.false)}"
    if course.overload() > OVERLOAD + course.trial.delay + 1e-9:
        return "failed", f"{1e3 * course.overload():.0f} ms above {course.max_force:g} N"
    cause = "" if course.trial.task == "pushed" else _shortfall(course, error)
    if not cause:
        return "ok", ""
    last = course.last(course.force)
    if last.min() > 0 and np.ptp(last) > (RIPPLE if course.trial.task == "press" else _SWING):
        return "failed", f"limit cycle of {np.ptp(last):.1f} N"
    refusals = course.refusals.copy()
    misread = quantile(course.misread) or 0.0
    kept = float(np.mean(course.force[round(_SETTLED / course.tick) :] > 0))
    if "error" not in cause or error is None or error > PATH_WITHIN + misread or kept < _KEPT:
        del refusals[LimitKind.PLACE_UNCERTAIN.value]  # not because of the places read
    for reason, _ in refusals.most_common(1):
        return "refused", f"{reason}: {cause}"
    return "failed", cause


def _shortfall(course: _Course, error: float | None) -> str:
    """Return what the trial misses of its goal; empty where it reaches it."""
    if course.trial.task == "path":
        if error is None:
            return "no contact"
        if course.walked < 0.8 * _PATH_SPEED * (len(course.force) * course.tick - _SETTLED):
            return f"stops after {1e3 * course.walked:.0f} mm"
        return f"error of {1e3 * error:.1f} mm" if error > PATH_WITHIN else ""
    last = course.last(course.force)
    if abs(last.mean() - GOAL) > WITHIN:
        return f"{last.mean():.2f} N"
    return f"ripple of {np.ptp(last):.2f} N" if np.ptp(last) > RIPPLE else ""
