"""Takes a contact from one place of the skin to another that is far from it: lift, carry, press.

What is touched stays where it is in the world; the arm lets go of it, moves so that the other place comes over it, and
presses until it feels it there. Where that cannot be done it goes back to what it held, and says why.

``RegraspPlan`` looks for a route: postures over which the arm goes from what it touches to touch it elsewhere.
``Regrasp`` is one contact on its way; ``RegraspManager`` keeps the one that is, from the question to its end.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from app.contacts.regions import ContactRegion
from app.control.command import RegraspState
from app.control.inverse_kinematics import LinkPoint, PointTarget, solve_inverse_kinematics
from app.control.joint_impedance import joint_limits
from app.control.limits import Limit, LimitKind, RegraspFailure
from app.control.path_following.surface_path import PathCrossing
from app.core.arrays import FloatArray
from app.geometry.mesh import SurfacePoint
from app.robots.kinematics import Configuration
from app.robots.robot import Robot
from app.skin.skin import Skin

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
class RegraspRoute:
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


class RegraspPlan:
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
        touched: LinkPoint,
        wanted: LinkPoint,
    ) -> None:
        self._start, self._rest, self._touched, self._wanted = start.copy(), rest, touched, wanted
        self._configuration, (self._lower, self._upper) = configuration, joint_limits(robot)
        configuration.update(start)
        pose = configuration.pose(touched.link)
        self._goal = PointTarget(pose.points(touched.point), pose.rotation @ touched.normal)
        self._surfaces = {link.name: _some(link.mesh.vertices) for link in robot.links[1:] if link.mesh is not None}
        self.route: RegraspRoute | None = None
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
                    self.route = RegraspRoute(self._start, lifted, over, above, pressed)
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

    def _aimed(self, spot: LinkPoint, goal: PointTarget, start: FloatArray) -> Generator[None, None, FloatArray | None]:
        tried: FloatArray | None = None
        for posture in solve_inverse_kinematics(self._configuration, spot, goal, start, self._lower, self._upper):
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


JOINT_SPEED = 0.6
"""Of any joint on the way [rad/s]."""
SPEED, SLOW = 0.2, 0.02
"""Of either place, at most [m/s]; slow on the leg at whose end it will touch."""
LONGEST = 20.0
"""On the way there, or back [s]."""
BUMP = 1.0
"""Force of a contact on the way that turns the arm back [N]."""
PITCHES = 3.0
"""So near to the place that is wanted a contact on the same patch counts as the one."""
_ROUNDS = 5
"""Of the search for a way, each tick."""
_GENTLE = 0.1
"""Time constant of changes of speed [s]."""
_NEAR, _RATE = 0.01, 6.0


class Regrasp:
    """One contact on its way. Mutable.

    Args:
        plan: Finds the way.
        skin: Of the arm.
        leaves: The place that touches now.
        enters: The place that is to touch.
        pitch: Of the taxels [m].
        known: Ids of the contacts there are at the start: they are in nobody's way.

    Attributes:
        state: Where it is.
        failure: Why it turned back or failed; None until then.
    """

    def __init__(
        self,
        plan: RegraspPlan,
        skin: Skin,
        leaves: SurfacePoint,
        enters: SurfacePoint,
        pitch: float,
        known: frozenset[int],
    ) -> None:
        self._plan, self._skin, self._pitch, self._known = plan, skin, pitch, known
        self.leaves, self.enters = leaves, enters
        self.state = RegraspState.PLAN
        self.failure: RegraspFailure | None = None
        self._links = skin.link(leaves), skin.link(enters)
        self._time = 0.0
        self._way: list[FloatArray] = []
        self._speed: FloatArray | None = None

    @property
    def limit(self) -> Limit:
        """What it does, or why it failed."""
        match self.state:
            case RegraspState.PLAN:
                return Limit(LimitKind.REGRASP_PLANNED, self._links)
            case RegraspState.RETURN:
                return Limit(LimitKind.REGRASP_RETURNS, self._links, cause=self.failure)
            case RegraspState.FAILED:
                return Limit(LimitKind.REGRASP_FAILED, self._links, cause=self.failure)
            case _:
                return Limit(LimitKind.REGRASP_MOVES, self._links)

    def watch(self, regions: Sequence[ContactRegion], dt: float) -> ContactRegion | None:
        """Go on by what is felt; the contact in hand as soon as it has arrived, there or back.

        Args:
            regions: All contacts.
            dt: Since the last tick [s].
        """
        self._time += dt
        if self.state is RegraspState.PLAN:
            self._look()
        elif self.state.moves:
            return self._feel(regions)
        return None

    def speed(self, start: FloatArray, configuration: Configuration, dt: float) -> FloatArray:
        """(n,) joint velocity along the way, from the wanted posture ``start`` (n,); bounded, and without jumps."""
        while self._way and np.abs(self._way[0] - start).max(initial=0.0) < _NEAR:
            self._leg_done()
        wanted = self._towards(start, configuration) if self._way else np.zeros_like(start)
        before = np.zeros_like(start) if self._speed is None else self._speed
        self._speed = before + min(dt / _GENTLE, 1.0) * (wanted - before)
        return self._speed

    def _look(self) -> None:
        self._plan.look(_ROUNDS)
        if not self._plan.done:
            return
        if self._plan.route is None:
            self.state, self.failure = RegraspState.FAILED, RegraspFailure.UNREACHABLE
            return
        self.state, self._time, self._way = RegraspState.LIFT, 0.0, [self._plan.route.lifted]

    def _leg_done(self) -> None:
        """The next leg; at the end of the last one nothing was felt where it should be."""
        self._way.pop(0)
        route = self._plan.route
        if self._way or route is None:
            return
        if self.state is RegraspState.LIFT:
            self.state, self._way = RegraspState.CARRY, [route.over, route.above]
        elif self.state is RegraspState.CARRY:
            self.state, self._way = RegraspState.PRESS, [route.pressed]
        elif self.state is RegraspState.PRESS:
            self._turn_back(RegraspFailure.NOTHING_THERE)
        else:
            self.state = RegraspState.FAILED

    def _feel(self, regions: Sequence[ContactRegion]) -> ContactRegion | None:
        if self.state is RegraspState.RETURN:
            found = self._arrive(regions, self.leaves, RegraspState.FAILED) if len(self._way) <= 1 else None
            self.state = RegraspState.FAILED if self._time > LONGEST else self.state
            return found
        if self._time > LONGEST:
            self._turn_back(RegraspFailure.TIMEOUT)
        elif self.state is not RegraspState.LIFT:
            arrived = self._arrive(regions, self.enters, RegraspState.ARRIVED)
            if arrived is not None:
                return arrived
            if any(region.force > BUMP and region.id not in self._known for region in regions):
                self._turn_back(RegraspFailure.OBSTACLE)
            elif self._at(regions, self.leaves) is not None:
                self._turn_back(RegraspFailure.OBJECT_FOLLOWS)
        return None

    def _arrive(self, regions: Sequence[ContactRegion], at: SurfacePoint, state: RegraspState) -> ContactRegion | None:
        """The contact about a place, if there is one: then it is over."""
        region = self._at(regions, at)
        self.state = self.state if region is None else state
        return region

    def _at(self, regions: Sequence[ContactRegion], at: SurfacePoint) -> ContactRegion | None:
        place, near = self._skin.position(at), PITCHES * self._pitch
        return next(
            (r for r in regions if r.at.patch == at.patch and np.linalg.norm(r.link_position - place) < near), None
        )

    def _turn_back(self, failure: RegraspFailure) -> None:
        route = self._plan.route
        assert route is not None
        lifted = [] if self.state is RegraspState.LIFT else [route.lifted]
        came_over = self.state is RegraspState.PRESS or (self.state is RegraspState.CARRY and len(self._way) == 1)
        self.state, self.failure, self._time = RegraspState.RETURN, failure, 0.0
        self._way = [*([route.over] if came_over else []), *lifted, route.start]

    def _towards(self, start: FloatArray, configuration: Configuration) -> FloatArray:
        """Straight to the next posture, as fast as joints and places may move, slower near its end."""
        off = self._way[0] - start
        fastest = float(np.abs(off).max())
        moved = max(
            float(np.linalg.norm(configuration.jacobian(self._skin.link(at), self._skin.position(at)) @ off))
            for at in (self.leaves, self.enters)
        )
        touches = self.state is RegraspState.PRESS or (self.state is RegraspState.RETURN and len(self._way) == 1)
        pace = min(JOINT_SPEED / fastest, (SLOW if touches else SPEED) / max(moved, 1e-9), _RATE)
        return pace * off


class RegraspManager:
    """At most one transfer. Mutable; ``reset`` lets go of it.

    Args:
        robot: Whose arm; without one, or without joints, nothing can be carried.

    Attributes:
        crossing: Over which it goes; None while there is none.
    """

    def __init__(self, robot: Robot | None) -> None:
        self._robot = robot if robot is not None and robot.joints else None
        self._trial = None if self._robot is None else Configuration(self._robot)
        self.reset()

    def reset(self) -> None:
        """Nothing is carried."""
        self.crossing: PathCrossing | None = None
        self._asked: tuple[Skin, float, ContactRegion, frozenset[int]] | None = None
        self._transfer: Regrasp | None = None

    @property
    def state(self) -> RegraspState | None:
        """Where the contact is on its way; None while nothing is carried."""
        if self.crossing is None:
            return None
        return RegraspState.PLAN if self._transfer is None else self._transfer.state

    @property
    def moves(self) -> bool:
        """Whether the arm is on the way, without a task for any contact."""
        return self._transfer is not None and self._transfer.state.moves

    @property
    def limit(self) -> Limit | None:
        """What goes on; at the end why it failed. None before the search has begun."""
        return None if self._transfer is None else self._transfer.limit

    def ask(
        self, crossing: PathCrossing, region: ContactRegion, regions: Sequence[ContactRegion], skin: Skin, pitch: float
    ) -> bool:
        """Begin; false where there is no arm that could.

        Args:
            crossing: From where to where.
            region: The contact.
            regions: All there are.
            skin: Of the arm.
            pitch: Of its taxels [m].
        """
        if self._robot is None:
            return False
        self.crossing, self._transfer = crossing, None
        self._asked = skin, pitch, region, frozenset(one.id for one in regions)
        return True

    def watch(self, regions: Sequence[ContactRegion], dt: float) -> ContactRegion | None:
        """Go on by what is felt; the contact as soon as it has arrived, there or back."""
        return None if self._transfer is None else self._transfer.watch(regions, dt)

    def speed(self, start: FloatArray, rest: FloatArray, configuration: Configuration, dt: float) -> FloatArray | None:
        """(n,) joint velocity of an arm on the way; None while it is not.

        Args:
            start: (n,) the wanted posture.
            rest: (n,) the posture at rest.
            configuration: At the present posture.
            dt: To the next tick [s].
        """
        if self._asked is not None:
            self._transfer, self._asked = self._begin(start, rest, *self._asked), None
        return self._transfer.speed(start, configuration, dt) if self._transfer is not None and self.moves else None

    def _begin(
        self,
        start: FloatArray,
        rest: FloatArray,
        skin: Skin,
        pitch: float,
        region: ContactRegion,
        known: frozenset[int],
    ) -> Regrasp:
        assert self._robot is not None
        assert self._trial is not None
        assert self.crossing is not None
        touched = LinkPoint(region.link, region.link_position, region.link_normal)
        wanted = _spot(skin, self.crossing.enters)
        plan = RegraspPlan(self._robot, self._trial, start, rest, touched, wanted)
        return Regrasp(plan, skin, region.at, self.crossing.enters, pitch, known)


def _spot(skin: Skin, at: SurfacePoint) -> LinkPoint:
    return LinkPoint(skin.link(at), skin.position(at), skin.normal(at))
