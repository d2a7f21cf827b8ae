"""A way to another place of the skin: postures over which the arm goes from what it touches to touch it elsewhere."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray
from app.control.aim import Goal, Spot, aim
from app.control.gains import joint_limits
from app.robots.configuration import Configuration
from app.robots.robot import Robot

HEIGHTS = (0.06, 0.03)
"""How far the skin is lifted off what it touches [m]; the less where it cannot be more."""
ABOVE = 0.015
"""How far over its place the skin slows down [m]."""
DEPTH = 0.01
"""How far past its place the skin goes for what it is to touch [m]."""
_WIDE, _LONG = 0.04, 0.25
"""Half width and length of the room that is left to what is touched, along the normal from its place [m]."""
_POINTS = 150
"""Of each link's surface, that must stay out of it."""
_LOOKS = 12
"""Postures looked at along each leg."""
_LIFTS, _LEAST = 20, 0.02
"""Rounds of lifting, and how little a joint velocity may move the place at least [m/rad]."""
_STARTS = 8
"""Postures drawn by lot from which a way is sought, besides the present one and the one at rest."""


@dataclass(frozen=True, eq=False)
class Route:
    """Postures (n,) one after the other.

    Attributes:
        start: Where it touches now.
        lifted: Off what it touches.
        over: Over it with the other place; between the two in a straight line of the joints.
        above: The same, nearer.
        pressed: Touching with the other place.
    """

    start: FloatArray
    lifted: FloatArray
    over: FloatArray
    above: FloatArray
    pressed: FloatArray


class CarryPlan:
    """Looks for a route, a little at each tick. Mutable.

    Args:
        robot: Which arm.
        configuration: Of it, moved as the search likes.
        start: (n,) the posture now.
        rest: (n,) another one to begin from.
        touched: The place that touches now.
        wanted: The place that is to touch instead.

    Attributes:
        route: None until it is found.
        done: Whether the search is over.

    Cost: 0.1 ms a round; 100 to 300 rounds where there is a way, at most 2500.
    """

    def __init__(
        self,
        robot: Robot,
        configuration: Configuration,
        start: FloatArray,
        rest: FloatArray,
        touched: Spot,
        wanted: Spot,
    ) -> None:
        self._start, self._rest, self._touched, self._wanted = start.copy(), rest, touched, wanted
        self._configuration, (self._lower, self._upper) = configuration, joint_limits(robot)
        configuration.update(start)
        pose = configuration.pose(touched.link)
        self._goal = Goal(pose.points(touched.point), pose.rotation @ touched.normal)
        self._surfaces = {link.name: _some(link.mesh.vertices) for link in robot.links[1:] if link.mesh is not None}
        self.route: Route | None = None
        self.done = False
        self._search = self._rounds()

    def look(self, rounds: int) -> None:
        """Search on for so many rounds."""
        for _ in range(rounds):
            try:
                next(self._search)
            except StopIteration:
                self.done = True
                return

    def _rounds(self) -> Iterator[None]:
        for height in HEIGHTS:
            lifted = yield from self._lifted(height)
            if lifted is None:
                continue
            for begin in self._begins(lifted):
                over = yield from self._aimed(self._wanted, self._goal.raised(-height), begin)
                if over is None:
                    continue
                above = yield from self._aimed(self._wanted, self._goal.raised(-ABOVE), over)
                pressed = yield from self._aimed(self._wanted, self._goal.raised(DEPTH), over)
                if above is not None and pressed is not None and (yield from self._is_free(lifted, over)):
                    self.route = Route(self._start, lifted, over, above, pressed)
                    return

    def _lifted(self, height: float) -> Generator[None, None, FloatArray | None]:
        """Straight off what is touched, by the least motion of the joints: to the side the place may go as it likes."""
        posture, spot, goal = self._start, self._touched, self._goal
        for _ in range(_LIFTS):
            self._configuration.update(posture)
            high = float(goal.normal @ (goal.point - self._configuration.pose(spot.link).points(spot.point)))
            if high > 0.95 * height:
                return posture
            row = goal.normal @ self._configuration.jacobian(spot.link, spot.point)
            row = row * ~(((posture <= self._lower) & (row > 0)) | ((posture >= self._upper) & (row < 0)))
            step = min(height - high, height / 6) * row / max(float(row @ row), _LEAST**2)
            posture = np.clip(posture - step, self._lower, self._upper)
            yield
        return None

    def _begins(self, lifted: FloatArray) -> Iterator[FloatArray]:
        yield lifted
        yield self._rest
        lot = np.random.default_rng(0)
        reach = np.minimum(np.array([1.2]), np.minimum(self._upper - lifted, lifted - self._lower).clip(0.3))
        for _ in range(_STARTS):
            yield np.clip(lifted + lot.uniform(-reach, reach), self._lower, self._upper)

    def _aimed(self, spot: Spot, goal: Goal, start: FloatArray) -> Generator[None, None, FloatArray | None]:
        tried: FloatArray | None = None
        for posture in aim(self._configuration, spot, goal, start, self._lower, self._upper):
            tried = posture
            yield
        return tried

    def _is_free(self, lifted: FloatArray, over: FloatArray) -> Generator[None, None, bool]:
        """Whether the whole arm stays out of the room of what is touched."""
        for share in np.linspace(0, 1, _LOOKS):
            self._configuration.update(lifted + share * (over - lifted))
            if any(self._inside(link, points) for link, points in self._surfaces.items()):
                return False
            yield
        return True

    def _inside(self, link: str, points: FloatArray) -> bool:
        away = self._configuration.pose(link).points(points) - self._goal.point
        along = away @ self._goal.normal
        aside = np.linalg.norm(away - along[:, None] * self._goal.normal, axis=1)
        return bool(((along > -HEIGHTS[-1] / 2) & (along < _LONG) & (aside < _WIDE)).any())


def _some(vertices: FloatArray) -> FloatArray:
    return vertices[:: max(len(vertices) // _POINTS, 1)]
