"""Takes a contact from one place of the skin to another that is far from it: lift, carry, press.

What is touched stays where it is in the world; the arm lets go of it, moves so that the other place comes over it, and
presses until it feels it there. Where that cannot be done it goes back to what it held, and says why.

``regrasp_plan`` looks for a route: postures over which the arm goes from what it touches to touch it elsewhere.
``Regrasp`` is one contact on its way; ``RegraspManager`` keeps the one that is, from the question to its end.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.command import RegraspState
from tactile_maps.control.motion.limits import Limit, LimitKind, RegraspFailure
from tactile_maps.control.path_following.clearance import Clearance, Surroundings, nothing_around
from tactile_maps.control.path_following.inverse_kinematics import LinkPoint
from tactile_maps.control.path_following.regrasp_plan import RegraspPlan
from tactile_maps.control.path_following.surface_path import PathCrossing
from tactile_maps.core.arrays import FloatArray, largest
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.model.skin import Skin

JOINT_SPEED = 0.6
"""Of any joint on the way [rad/s]."""
SPEED = 0.2
SLOW = 0.02
"""Of either place, at most [m/s]; slow on the leg at whose end it will touch."""
LONGEST = 20.0
"""On the way there, or back [s]; and twice what its length takes at ``JOINT_SPEED``, where it leads around."""
BUMP = 1.0
"""Force of a contact on the way that turns the arm back [N]."""
HARDER = 5.0
"""By so much more than before the lift [N] a lift may press anything that was touched; then the arm turns back."""
PITCHES = 3.0
"""So near to the place that is wanted a contact on the same patch counts as the one."""
_POSTURES = 30
"""Looked at in the search for a way, each tick: 1 to 2 ms."""
_GENTLE = 0.1
"""Time constant of changes of speed [s]."""
_NEAR = 0.01
_RATE = 6.0


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
        self._plan = plan
        self._skin = skin
        self._pitch = pitch
        self._known = known
        self.leaves = leaves
        self.enters = enters
        self.state = RegraspState.PLAN
        self.failure: RegraspFailure | None = None
        self._links = skin.link(leaves), skin.link(enters)
        self._time = 0.0
        self._longest = LONGEST
        self._way: list[FloatArray] = []
        self._behind: list[FloatArray] = []
        self._speed: FloatArray | None = None
        self._held = 0.0

    @property
    def limit(self) -> Limit:
        """What it does, or why it failed."""
        match self.state:
            case RegraspState.PLAN:
                return Limit(LimitKind.REGRASP_PLANNED, self._links)
            case RegraspState.RETURN:
                return Limit(LimitKind.REGRASP_RETURNS, self._links, cause=self.failure)
            case RegraspState.FAILED:
                problem = self._plan.problem
                if problem is None:
                    return Limit(LimitKind.REGRASP_FAILED, self._links, cause=self.failure)
                return Limit(
                    LimitKind.REGRASP_FAILED,
                    self._links,
                    value=problem.short_by,
                    cause=problem.cause,
                    between=problem.between,
                )
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
            self._held = max((region.force for region in regions), default=0.0)
            self._look()
        elif self.state.moves:
            return self._feel(regions)
        return None

    def speed(self, start: FloatArray, configuration: Configuration, dt: float) -> FloatArray:
        """(n,) joint velocity along the way, from the wanted posture ``start`` (n,); bounded, and without jumps."""
        while self._way and largest(self._way[0] - start) < _NEAR:
            self._leg_done()
        wanted = self._towards(start, configuration) if self._way else np.zeros_like(start)
        before = np.zeros_like(start) if self._speed is None else self._speed
        self._speed = before + min(dt / _GENTLE, 1.0) * (wanted - before)
        return self._speed

    def _look(self) -> None:
        self._plan.look(_POSTURES)
        route = self._plan.route
        if self._plan.problem is not None:
            self.state = RegraspState.FAILED
            self.failure = self._plan.problem.cause
        elif route is not None:
            self.state = RegraspState.LIFT
            self._time = 0.0
            self._way = [route.lifted]
            self._behind = [route.start]
            around = [float(np.abs(b - a).max()) for a, b in pairwise((route.lifted, *route.around, route.over))]
            self._longest = LONGEST + 2 * sum(around) / JOINT_SPEED

    def _leg_done(self) -> None:
        """The next leg; at the end of the last one nothing was felt where it should be."""
        self._behind.append(self._way.pop(0))
        route = self._plan.route
        if self._way or route is None:
            return
        if self.state is RegraspState.LIFT:
            self.state = RegraspState.CARRY
            self._way = [*route.around, route.over, route.above]
        elif self.state is RegraspState.CARRY:
            self.state = RegraspState.PRESS
            self._way = [route.pressed]
        elif self.state is RegraspState.PRESS:
            self._turn_back(RegraspFailure.NOTHING_THERE)
        else:
            self.state = RegraspState.FAILED

    def _feel(self, regions: Sequence[ContactRegion]) -> ContactRegion | None:
        if self.state is RegraspState.RETURN:
            found = self._arrive(regions, self.leaves, RegraspState.FAILED) if len(self._way) <= 1 else None
            self.state = RegraspState.FAILED if self._time > self._longest else self.state
            return found
        if self._time > self._longest:
            self._turn_back(RegraspFailure.TIMEOUT)
        elif self.state is RegraspState.LIFT and any(region.force > self._held + HARDER for region in regions):
            self._turn_back(RegraspFailure.NO_LIFT)
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
        place = self._skin.position(at)
        near = PITCHES * self._pitch
        return next(
            (r for r in regions if r.at.patch == at.patch and np.linalg.norm(r.link_position - place) < near), None
        )

    def _turn_back(self, failure: RegraspFailure) -> None:
        """Back by the way it came."""
        self.state = RegraspState.RETURN
        self.failure = failure
        self._time = 0.0
        self._way = self._behind[::-1]
        self._behind = []

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
        surroundings: Tells what stands around.

    Attributes:
        crossing: Over which it goes; None while there is none.
    """

    def __init__(self, robot: Robot | None, *, surroundings: Surroundings = nothing_around) -> None:
        self._robot = robot if robot is not None and robot.joints else None
        self._trial = None if self._robot is None else Configuration(self._robot)
        self._surroundings = surroundings
        self._clearance: tuple[Skin, Clearance] | None = None
        self.reset()

    def prepare(self, skin: Skin) -> None:
        """Build the shapes that collide, ahead of the first question: no control tick has the time.

        Args:
            skin: Of the arm, as the map that is in force next has it; what is built for another is let go.

        Raises:
            RobotError: MuJoCo refuses the model.

        Cost: as ``Clearance``; none where it is there.
        """
        if self._robot is not None:
            self._clear_of(skin)

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
        self.crossing = crossing
        self._transfer = None
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
            self._transfer = self._begin(start, rest, *self._asked)
            self._asked = None
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
        clearance = self._clear_of(skin)
        pose = self._posed(start, touched.link)
        place = pose.points(touched.point)
        normal = pose.rotation @ touched.normal
        clearance.begin(start, self._surroundings(), touched.link, place, normal)
        plan = RegraspPlan(self._robot, self._trial, clearance, start, rest, touched, wanted)
        return Regrasp(plan, skin, region.at, self.crossing.enters, pitch, known)

    def _posed(self, posture: FloatArray, link: str) -> Pose:
        assert self._trial is not None
        self._trial.update(posture)
        return self._trial.pose(link)

    def _clear_of(self, skin: Skin) -> Clearance:
        assert self._robot is not None
        if self._clearance is None or self._clearance[0] is not skin:
            self._clearance = skin, Clearance(self._robot, skin, self._surroundings())
        return self._clearance[1]


def _spot(skin: Skin, at: SurfacePoint) -> LinkPoint:
    return LinkPoint(skin.link(at), skin.position(at), skin.normal(at))
