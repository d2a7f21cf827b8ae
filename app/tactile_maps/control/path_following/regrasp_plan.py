"""Planning of a regrasp: a route by which the arm leaves an object and touches it with another place of the skin.

Postures at which the other place touches come from inverse kinematics, started at the current posture, at rest, at the
postures of ``ReachSearch``, and at some random ones. The first that a straight line of the joints reaches is used;
without one, a path around is searched for by sampling. If there is no route, the reason is reported.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.control.motion.joint_impedance import joint_limits
from tactile_maps.control.motion.limits import RegraspFailure
from tactile_maps.control.path_following.clearance import Clearance
from tactile_maps.control.path_following.inverse_kinematics import (
    TILT,
    LinkPoint,
    PointTarget,
    solve_inverse_kinematics,
)
from tactile_maps.control.path_following.motion_planning import Pair, RrtConnect, straight
from tactile_maps.control.path_following.reach import ReachSearch
from tactile_maps.core.arrays import FloatArray
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot

HEIGHTS = (0.06, 0.03, 0.018)
"""Heights to which the skin is lifted off the object [m]; smaller ones are tried if larger ones fail."""
ABOVE = 0.015
"""Distance above the place at which the skin slows down [m]."""
DEPTH = 0.01
"""Distance past the place that the skin moves to touch the object [m]."""
_MOST_LEAN = 0.03
"""Largest distance by which an object may touch the skin before its place does [m]."""
_LIFTS = 20
_LEAST = 0.02
"""Largest number of steps of a lift, and smallest motion of the place per joint velocity [m/rad]."""
_LOOKS = 40
_DEEPER = 5e-5
"""Number of postures checked on a lift, and largest increase of the depth [m]: 1 N on a stiff skin."""
_STARTS = 12
"""Number of random postures from which inverse kinematics starts."""
_BEYOND = 25
"""Number of random angles of the joints beyond the place."""
_GOALS = 4
"""Number of goal postures of a path around."""
_OF_AIM = 2
_OF_REACH = 15
"""Cost of a step of inverse kinematics and of the reach search, in postures checked."""


@dataclass(frozen=True, eq=False)
class RegraspRoute:
    """Sequence of postures (n,).

    Attributes:
        start: Current posture, touching.
        lifted: Lifted off the object.
        around: Postures between ``lifted`` and ``over``; empty if the straight line of the joints is clear.
        over: Other place over the object.
        above: Other place near the object.
        pressed: Other place touching.
    """

    start: FloatArray
    lifted: FloatArray
    around: tuple[FloatArray, ...]
    over: FloatArray
    above: FloatArray
    pressed: FloatArray


@dataclass(frozen=True)
class NoRoute:
    """Reason why no route was found.

    Attributes:
        cause: ``UNREACHABLE`` and ``FACES_AWAY`` are proved; the others result from the search.
        short_by: Smallest distance from an unreachable place [m].
        between: Names of the pair that collided most often; empty without collisions.
    """

    cause: RegraspFailure
    short_by: float | None = None
    between: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class _Landing:
    """Postures (n,) from which the other place touches: over, above and pressing."""

    over: FloatArray
    above: FloatArray
    pressed: FloatArray


class RegraspPlan:
    """Searches for a route, in small steps at each tick. Mutable.

    Args:
        robot: The robot.
        configuration: Configuration that the search may change.
        clearance: Clearance of the robot, begun at ``start``.
        start: (n,) current posture.
        rest: (n,) further posture from which to start.
        touched: The place that touches now.
        entering: The place that will touch instead.

    Attributes:
        route: The route; None until it is found.
        problem: Reason why none was found; None until then.

    Cost: 0.05 ms for each posture checked; some hundred if the straight line is clear, at most about 20,000.
    """

    def __init__(
        self,
        robot: Robot,
        configuration: Configuration,
        clearance: Clearance,
        start: FloatArray,
        rest: FloatArray,
        touched: LinkPoint,
        entering: LinkPoint,
    ) -> None:
        self._start = start.copy()
        self._rest = rest
        self._touched, self._entering = (
            replace(spot, point=clearance.on_hull(spot.link, spot.point, spot.normal)) for spot in (touched, entering)
        )
        self._configuration, (self._lower, self._upper) = configuration, joint_limits(robot)
        self._clearance = clearance
        configuration.update(start)
        pose = configuration.pose(touched.link)
        self._goal = PointTarget(pose.points(touched.point), pose.rotation @ touched.normal)
        self.route: RegraspRoute | None = None
        self.problem: NoRoute | None = None
        self._met: Counter[Pair] = Counter()
        self._comes = False
        self._lot = np.random.default_rng(0)
        self._search = self._rounds()

    @property
    def done(self) -> bool:
        """Whether the search is over."""
        return self.route is not None or self.problem is not None

    def look(self, postures: int) -> None:
        """Continue the search for the time of checking this number of postures."""
        while postures > 0 and not self.done:
            postures -= next(self._search, 0)

    def _rounds(self) -> Iterator[int]:
        lifted = yield from self._lifted_clear()
        if lifted is None:
            self.problem = NoRoute(RegraspFailure.NO_LIFT, between=self._most_met)
            return
        self._met.clear()
        landings: list[_Landing] = []
        begins = self._begins(lifted)
        for goal in self._leaning():
            begin = yield from _next_posture(begins)
            if begin is None:
                break
            landing = yield from self._landing(begin, goal)
            if landing is None:
                continue
            self._clearance.meeting(None)
            if (yield from straight(self._clearance, lifted, landing.over, self._met)):
                self._found(lifted, (), landing)
                return
            landings.append(landing)
            if len(landings) == _GOALS:
                break
        if self.problem is None and landings:
            yield from self._around(lifted, landings)
        elif self.problem is None:
            cause = RegraspFailure.BLOCKED if self._met else RegraspFailure.NO_POSTURE
            self.problem = NoRoute(cause, between=self._most_met)

    def _around(self, lifted: FloatArray, landings: list[_Landing]) -> Iterator[int]:
        self._clearance.meeting(None)
        goals = [landing.over for landing in landings]
        way = yield from RrtConnect(self._clearance, lifted, goals, self._lower, self._upper, self._met).search()
        if way is None:
            self.problem = NoRoute(RegraspFailure.NO_PATH, between=self._most_met)
            return
        end = next(landing for landing in landings if np.array_equal(landing.over, way[-1]))
        self._found(lifted, tuple(way[1:-1]), end)

    def _found(self, lifted: FloatArray, around: tuple[FloatArray, ...], end: _Landing) -> None:
        self.route = RegraspRoute(self._start, lifted, around, end.over, end.above, end.pressed)

    @property
    def _most_met(self) -> tuple[str, ...]:
        return self._met.most_common(1)[0][0] if self._met else ()

    def _lifted_clear(self) -> Generator[int, None, FloatArray | None]:
        self._clearance.meeting(self._touched.link, leaves=True)
        for height in HEIGHTS:
            lifted = yield from self._lifted(height)
            if lifted is None or not (yield from self._comes_off(lifted)):
                continue
            if (yield from straight(self._clearance, self._start, lifted, self._met)):
                return lifted
        return None

    def _comes_off(self, lifted: FloatArray) -> Generator[int, None, bool]:
        """Return whether no posture on the way to ``lifted`` presses deeper than the start."""
        link = self._touched.link
        touched = self._clearance.touched
        deepest = min(self._clearance.distance(self._start, link, touched), 0.0) - _DEEPER
        for share in np.linspace(0, 1, _LOOKS):
            yield 1
            if self._clearance.distance(self._start + share * (lifted - self._start), link, touched) < deepest:
                self._met[link, touched] += 1
                return False
        return True

    def _lifted(self, height: float) -> Generator[int, None, FloatArray | None]:
        """Return a posture straight off the object by the least motion of the joints; the place may move sideways."""
        posture = self._start
        spot = self._touched
        goal = self._goal
        for _ in range(_LIFTS):
            self._configuration.update(posture)
            high = float(goal.normal @ (goal.point - self._configuration.pose(spot.link).points(spot.point)))
            if high > 0.95 * height:
                return posture
            row = goal.normal @ self._configuration.jacobian(spot.link, spot.point)
            row = row * ~(((posture <= self._lower) & (row > 0)) | ((posture >= self._upper) & (row < 0)))
            step = min(height - high, height / 6) * row / max(float(row @ row), _LEAST**2)
            posture = np.clip(posture - step, self._lower, self._upper)
            yield _OF_AIM
        return None

    def _begins(self, lifted: FloatArray) -> Iterator[FloatArray | int]:
        """Yield initial postures, and costs of finding them; sets ``problem`` if it is proved that none exists."""
        yield lifted
        yield self._rest
        reach = ReachSearch(self._configuration, self._entering, self._goal, lifted, self._lower, self._upper)
        while reach.found is None:
            reach.look()
            yield _OF_REACH
        yield from reach.found.seeds
        while not self._comes and not reach.done:
            reach.look()
            yield _OF_REACH
        if not reach.found.possible and not self._comes:
            short_by = reach.found.short_by
            cause = RegraspFailure.UNREACHABLE if short_by else RegraspFailure.FACES_AWAY
            self.problem = NoRoute(cause, short_by or None)
            return
        around = np.minimum(np.array([1.2]), np.minimum(self._upper - lifted, lifted - self._lower).clip(0.3))
        for _ in range(_STARTS):
            yield np.clip(lifted + self._lot.uniform(-around, around), self._lower, self._upper)

    def _leaning(self) -> Iterator[PointTarget]:
        """Yield the goal; once a posture has touched, also with a random tilt within the tolerance."""
        lot = np.random.default_rng(1)
        while True:
            yield self._goal
            if self._comes:
                side = np.cross(self._goal.normal, lot.normal(size=3))
                lean = np.tan(0.8 * TILT * lot.uniform()) * side / np.linalg.norm(side)
                normal = self._goal.normal + lean
                yield PointTarget(self._goal.point, normal / np.linalg.norm(normal))

    def _landing(self, begin: FloatArray, goal: PointTarget) -> Generator[int, None, _Landing | None]:
        touch = yield from self._aimed(goal, begin)
        if touch is None or self._tilt(touch) > TILT:
            return None
        self._comes = True
        self._clearance.meeting(self._entering.link)
        touch = yield from self._clear_of_itself(touch)
        if touch is None:
            return None
        # If the skin is tilted, the object touches it before its place does: all heights grow by this distance.
        meets = goal.raised(
            max(min(self._clearance.distance(touch, self._entering.link, self._clearance.touched), 0.0), -_MOST_LEAN)
        )
        above = yield from self._aimed(meets.raised(-ABOVE), touch)
        pressed = yield from self._aimed(meets.raised(DEPTH), touch)
        if pressed is None:  # at the end of its reach
            pressed = yield from self._aimed(meets.raised(DEPTH / 3), touch)
        if above is None or pressed is None:
            return None
        for height in HEIGHTS:
            over = yield from self._aimed(meets.raised(-height), above)
            if over is None:
                continue
            self._clearance.meeting(self._entering.link)
            if not (yield from straight(self._clearance, touch, over, self._met)):
                continue
            self._clearance.meeting(None)
            if (yield from straight(self._clearance, over, over, self._met)):
                return _Landing(over, above, pressed)
        return None

    def _tilt(self, posture: FloatArray) -> float:
        """Return the angle between the normals [rad]."""
        self._configuration.update(posture)
        normal = self._configuration.pose(self._entering.link).rotation @ self._entering.normal
        return float(np.arccos(np.clip(normal @ self._goal.normal, -1, 1)))

    def _clear_of_itself(self, touch: FloatArray) -> Generator[int, None, FloatArray | None]:
        """Return a collision-free posture: this one, or one with other angles of the joints beyond the place."""
        if (yield from straight(self._clearance, touch, touch, self._met)):
            return touch
        beyond = np.setdiff1d(np.arange(len(touch)), self._configuration.joints_before(self._entering.link))
        low = np.maximum(self._lower, touch - np.pi)[beyond]
        high = np.minimum(self._upper, touch + np.pi)[beyond]
        for _ in range(_BEYOND if len(beyond) else 0):
            touch = touch.copy()
            touch[beyond] = self._lot.uniform(low, high)
            if (yield from straight(self._clearance, touch, touch, self._met)):
                return touch
        return None

    def _aimed(self, goal: PointTarget, start: FloatArray) -> Generator[int, None, FloatArray | None]:
        tried: FloatArray | None = None
        for posture in solve_inverse_kinematics(
            self._configuration, self._entering, goal, start, self._lower, self._upper
        ):
            tried = posture
            yield _OF_AIM
        return tried


def _next_posture(begins: Iterator[FloatArray | int]) -> Generator[int, None, FloatArray | None]:
    """Return the next posture of ``begins``, and yield the costs before it; None at the end."""
    for found in begins:
        if not isinstance(found, int):
            return found
        yield found
    return None
