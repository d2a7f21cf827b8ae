"""Regrasp of a contact at a distant place of the skin: lift, carry, press.

The object stays where it is in the world. The arm releases it, moves the other place over it, and presses until it
reads a contact there. If that fails, the arm returns to the first place and reports the reason.

``regrasp_plan`` searches for a route of postures. ``Regrasp`` is one regrasp; ``RegraspManager`` keeps the current one
from the request to its end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
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
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.model.skin import Skin

JOINT_SPEED = 0.6
"""Largest speed of any joint on the way [rad/s]."""
SPEED = 0.2
SLOW = 0.02
"""Largest speeds of both places [m/s]; the slow one on the leg at whose end they touch."""
LONGEST = 20.0
"""Longest time for the way there, or back [s], plus twice the time for a path around at ``JOINT_SPEED``."""
BUMP = 1.0
"""Force of a contact on the way at which the arm turns back [N]."""
HARDER = 5.0
"""Largest increase of the force on a touched object during a lift [N]; beyond it the arm turns back."""
PITCHES = 3.0
"""Distance from the target place, in pitches, within which a contact on the same patch counts as arrived."""
_POSTURES = 30
"""Number of postures checked in each tick of planning: 1 to 2 ms."""
_GENTLE = 0.1
"""Time constant of changes of speed [s]."""
_NEAR = 0.01
_RATE = 6.0


class Regrasp:
    """A regrasp. Mutable.

    Args:
        plan: Plan of the route.
        skin: The arm's skin.
        leaves: The place that touches now.
        enters: The place that will touch.
        pitch: Pitch of the taxels [m].
        known: Ids of the contacts at the start, which are not obstacles.

    Attributes:
        state: Current phase.
        failure: Reason why it turned back or failed; None until then.
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
        """Current phase, or the reason of the failure."""
        match self.state:
            case RegraspState.PLAN:
                return Limit(LimitKind.REGRASP_PLANNED, self._links)
            case RegraspState.RETURN:
                return Limit(LimitKind.REGRASP_RETURNS, self._links, cause=self.failure)
            case RegraspState.FAILED:
                failed = Limit(LimitKind.REGRASP_FAILED, self._links, cause=self.failure)
                problem = self._plan.problem
                return failed if problem is None else replace(failed, value=problem.short_by, between=problem.between)
            case _:
                return Limit(LimitKind.REGRASP_MOVES, self._links)

    def watch(self, regions: Sequence[ContactRegion], dt: float) -> ContactRegion | None:
        """Continue with the current contacts; return the contact as soon as it has arrived, there or back.

        Args:
            regions: All contacts.
            dt: Time since the last tick [s].
        """
        self._time += dt
        if self.state is RegraspState.PLAN:
            self._held = max((region.force for region in regions), default=0.0)
            self._look()
        elif self.state.moves:
            return self._feel(regions)
        return None

    def speed(self, start: FloatArray, configuration: Configuration, dt: float) -> FloatArray:
        """Return the joint velocity (n,) along the way from the desired posture ``start`` (n,), without jumps."""
        while self._way and largest(self._way[0] - start) < _NEAR:
            self._leg_done()
        desired = self._towards(start, configuration) if self._way else np.zeros_like(start)
        before = np.zeros_like(start) if self._speed is None else self._speed
        self._speed = before + min(dt / _GENTLE, 1.0) * (desired - before)
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
        """Start the next leg; after the last one nothing was read at the expected place."""
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
            found = self._at(regions, self.leaves) if len(self._way) <= 1 else None
            if found is not None or self._time > self._longest:
                self.state = RegraspState.FAILED
            return found
        if self._time > self._longest:
            self._turn_back(RegraspFailure.TIMEOUT)
        elif self.state is RegraspState.LIFT and any(region.force > self._held + HARDER for region in regions):
            self._turn_back(RegraspFailure.NO_LIFT)
        elif self.state is not RegraspState.LIFT:
            arrived = self._at(regions, self.enters)
            if arrived is not None:
                self.state = RegraspState.ARRIVED
                return arrived
            if any(region.force > BUMP and region.id not in self._known for region in regions):
                self._turn_back(RegraspFailure.OBSTACLE)
            elif self._at(regions, self.leaves) is not None:
                self._turn_back(RegraspFailure.OBJECT_FOLLOWS)
        return None

    def _at(self, regions: Sequence[ContactRegion], at: SurfacePoint) -> ContactRegion | None:
        """Return the contact at a place."""
        place = self._skin.position(at)
        near = PITCHES * self._pitch
        return next(
            (r for r in regions if r.at.patch == at.patch and np.linalg.norm(r.link_position - place) < near), None
        )

    def _turn_back(self, failure: RegraspFailure) -> None:
        """Return by the same way."""
        self.state = RegraspState.RETURN
        self.failure = failure
        self._time = 0.0
        self._way = self._behind[::-1]
        self._behind = []

    def _towards(self, start: FloatArray, configuration: Configuration) -> FloatArray:
        """Return the velocity to the next posture, as fast as joints and places may move, slower near its end."""
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
    """Keeps at most one regrasp. Mutable; ``reset`` discards it.

    Args:
        robot: Robot with the arm; without one, or without joints, regrasps are not possible.
        surroundings: Returns the obstacles around the arm.

    Attributes:
        crossing: Crossing that it passes; None without a regrasp.
    """

    def __init__(self, robot: Robot | None, *, surroundings: Surroundings = nothing_around) -> None:
        self._robot = robot if robot is not None and robot.joints else None
        self._trial = None if self._robot is None else Configuration(self._robot)
        self._surroundings = surroundings
        self._clearance: tuple[Skin, Clearance] | None = None
        self.reset()

    def prepare(self, skin: Skin) -> None:
        """Build the collision shapes before the first request, since it takes longer than a control tick.

        Args:
            skin: The arm's skin on the next map; shapes of another skin are discarded.

        Raises:
            RobotError: MuJoCo rejects the model.

        Cost: as ``Clearance``; none if it has been built.
        """
        if self._robot is not None:
            self._clear_of(skin)

    def reset(self) -> None:
        """Discard the regrasp."""
        self.crossing: PathCrossing | None = None
        self._request: tuple[Skin, float, ContactRegion, frozenset[int]] | None = None
        self._transfer: Regrasp | None = None

    @property
    def state(self) -> RegraspState | None:
        """Current phase; None without a regrasp."""
        if self.crossing is None:
            return None
        return RegraspState.PLAN if self._transfer is None else self._transfer.state

    @property
    def moves(self) -> bool:
        """Whether the arm moves without a task for any contact."""
        return self._transfer is not None and self._transfer.state.moves

    @property
    def limit(self) -> Limit | None:
        """Current phase, at the end the reason of the failure; None before the search has begun."""
        return None if self._transfer is None else self._transfer.limit

    def request(
        self, crossing: PathCrossing, region: ContactRegion, regions: Sequence[ContactRegion], skin: Skin, pitch: float
    ) -> bool:
        """Request a regrasp; return False if there is no arm that could do it.

        Args:
            crossing: Crossing to pass.
            region: The contact.
            regions: All contacts.
            skin: The arm's skin.
            pitch: Pitch of its taxels [m].
        """
        if self._robot is None:
            return False
        self.crossing = crossing
        self._transfer = None
        self._request = skin, pitch, region, frozenset(one.id for one in regions)
        return True

    def watch(self, regions: Sequence[ContactRegion], dt: float) -> ContactRegion | None:
        """Continue with the current contacts; return the contact as soon as it has arrived, there or back."""
        return None if self._transfer is None else self._transfer.watch(regions, dt)

    def speed(self, start: FloatArray, rest: FloatArray, configuration: Configuration, dt: float) -> FloatArray | None:
        """Return the joint velocity (n,) during a regrasp; None while the arm does not move.

        Args:
            start: (n,) desired posture.
            rest: (n,) rest posture.
            configuration: The robot at its current posture.
            dt: Time to the next tick [s].
        """
        if self._request is not None:
            self._transfer = self._begin(start, rest, *self._request)
            self._request = None
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
        enters = self.crossing.enters
        touched = LinkPoint(region.link, region.link_position, region.link_normal)
        entering = LinkPoint(skin.link(enters), skin.position(enters), skin.normal(enters))
        clearance = self._clear_of(skin)
        self._trial.update(start)
        pose = self._trial.pose(touched.link)
        place = pose.points(touched.point)
        clearance.begin(start, self._surroundings(), touched.link, place, pose.rotation @ touched.normal)
        plan = RegraspPlan(self._robot, self._trial, clearance, start, rest, touched, entering)
        return Regrasp(plan, skin, region.at, enters, pitch, known)

    def _clear_of(self, skin: Skin) -> Clearance:
        assert self._robot is not None
        if self._clearance is None or self._clearance[0] is not skin:
            self._clearance = skin, Clearance(self._robot, skin, self._surroundings())
        return self._clearance[1]
