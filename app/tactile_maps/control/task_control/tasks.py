"""Goals of the contacts for the current task, tick by tick.

``keep_force`` keeps the strongest contact at the force goal and lets it slide. ``hold_point`` also keeps it at a place
of the skin: the first point of the path, or where it began. ``follow_path`` moves it along the path with the force, and
regrasps where the path continues at another place. All other contacts above the force goal are kept at it too, and may
slide. ``balance`` moves until all contacts press alike; a single one is kept at the goal. ``retreat`` moves away from
all contacts, and stays there. ``guide`` follows a hand in all directions, and stays where the hand leaves it: where
shear is measured it yields to the force along the skin, otherwise it keeps the place of the hand on the skin.

``keep_force`` and ``hold_point`` may have a goal of the force along the skin, the first as a vector, the second along
its direction only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import cos, inf, sin

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.command import RegraspState, TaskReport
from tactile_maps.control.motion.limits import Limit, LimitKind, RegraspFailure
from tactile_maps.control.motion.observation import TaskTick
from tactile_maps.control.motion.task_priority import ContactGoal, ContactPresence, ShearGoal
from tactile_maps.control.path_following.clearance import Surroundings, nothing_around
from tactile_maps.control.path_following.contact_place import ContactPlace
from tactile_maps.control.path_following.follower import PathFollower, across_borders, over_borders
from tactile_maps.control.path_following.regrasp import RegraspManager
from tactile_maps.control.path_following.surface_path import PathCrossing
from tactile_maps.control.task_control.contact_selection import ContactSelection
from tactile_maps.control.task_control.monitors import EnergyTank
from tactile_maps.core.arrays import FloatArray, length, within_length
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.paths import NEAR_PITCHES
from tactile_maps.robots.model.robot import Robot

SEARCH_TIME = 0.4
"""Time for which a lost contact is searched for along its normal [s]."""
OVER = 2.0
"""Speed at which the contact is moved over a crossing, where the target jumps, in multiples of the path's speed."""
PATH_TOLERANCE = 0.003
"""Distance from the path [m] for 95 % of a followed contact's places."""
_QUANTILE = 1.73
"""Ratio of the 95 % quantile of a radial error to its root mean square, for normal errors (Rayleigh distribution)."""
_PLACE_TIME = 2.0
"""Time constant of the mean uncertainty of a contact's place [s]: it passes some taxels in that time."""
SHEAR_TASKS = ("keep_force", "hold_point")
"""Tasks with a goal of the force along the skin."""
GUIDE_EASE = 4.0
"""Speed of a guided arm at a lasting pull over that at a sudden one: the gain of a sudden one is bound by stability."""
_MOST_USE = 0.9
"""Largest share of its friction that the goal of a contact's force along the skin uses."""
MOST_ERROR = 0.02
"""Largest error on the body that controllers receive [m]: farther targets are approached at the same speed."""


class TaskManager:
    """Tracks the contact of a task, where it began and its progress along the path. Mutable.

    Args:
        robot: Robot whose arm can regrasp; None disables regrasps.
        surroundings: Returns the obstacles around the arm.

    Attributes:
        follower: Follower of the path.
        regrasp: Manager of regrasps.
        target, error, force_goal, controlled: See ``TaskReport``.
        read_point: (2,) place on the map at which the contact of a path is read [m], which is not yet estimated between
            taxels; None for other tasks.
        lost: Whether the task's contact was lost for good, and nothing has touched since.
    """

    def __init__(self, robot: Robot | None = None, *, surroundings: Surroundings = nothing_around) -> None:
        self.follower = PathFollower()
        self.regrasp = RegraspManager(robot, surroundings=surroundings)
        self._selection = ContactSelection()
        self.reset()

    def reset(self) -> None:
        """Discard the contact and return to the start of the path."""
        self.follower.reset()
        self.regrasp.reset()
        self._selection.reset()
        self.target: SurfacePoint | None = None
        self.error: float | None = None
        self.force_goal: float | None = None
        self.controlled: tuple[int, ...] = ()
        self._task: object = None
        self._place: object = None
        self._last: ContactRegion | None = None
        self._searching = 0.0
        self.lost = False
        self._off_skin = False
        self._place_error: float | None = None
        self._contact_place = ContactPlace()
        self.read_point: FloatArray | None = None

    def report(self, tank: EnergyTank) -> TaskReport:
        """Return the progress of the task, with the energy counted by ``tank``."""
        follower = self.follower
        return TaskReport(
            target=self.target,
            error=self.error,
            force_goal=self.force_goal,
            controlled=self.controlled,
            laid_at=follower.laid_at,
            way=follower.way,
            energy=tank.given,
            tank=tank.level,
            piece=follower.piece,
            regrasp=self.regrasp.state,
        )

    def let_go(self) -> None:
        """Discard the contact; the path continues from its current position."""
        self._last = None
        self.controlled = ()
        self.regrasp.reset()

    def goals(self, now: TaskTick) -> list[ContactGoal]:
        """Return the current goals, the contact of the task first; empty without contacts."""
        self._start_if_new(now)
        self.error = None
        self.read_point = None
        goals = self._carried(now) if self.regrasp.moves else self._goals(now)
        _report_unmeasured_shear(now)
        self.force_goal = goals[0].force if goals else None
        self.controlled = tuple(goal.region.id for goal in goals if goal.presence is ContactPresence.FELT)
        return goals

    def _goals(self, now: TaskTick) -> list[ContactGoal]:
        region = self._contact(now.regions)
        if region is None:
            return self._search(now)
        new = self._last is None or self._last.id != region.id
        self._last = region
        self._searching = 0.0
        self.lost = False
        if now.settings.task == "balance":
            return _balanced(now)
        if now.settings.task == "retreat":
            return [ContactGoal(one, 0.0) for one in now.regions]
        goal = now.settings.force_goal
        if now.settings.task == "keep_force":
            others = self._selection.others(region, now.regions, goal)
            first = ContactGoal(region, goal, shear=_shear_goal(now, region))
            return [first, *(ContactGoal(one, goal) for one in others)]
        across = {one.id for one in across_borders(now, region)}
        apart = [one for one in now.regions if one.id not in across]
        others = self._selection.others(region, apart, goal)
        whole = over_borders(now, region)
        led = self._on_path if now.settings.task == "follow_path" else self._at_a_place
        return [led(now, whole, new), *(ContactGoal(one, goal) for one in others)]

    def _carried(self, now: TaskTick) -> list[ContactGoal]:
        """Return no goals during a regrasp; those of the task as soon as the contact has arrived."""
        region = self.regrasp.watch(now.regions, now.dt)
        crossing = self.regrasp.crossing
        carrying = self.regrasp.limit
        assert crossing is not None
        assert carrying is not None
        if self.regrasp.moves:
            now.limits.add(carrying)
            self._last = None
            return []
        if self.regrasp.state is RegraspState.ARRIVED:
            self.follower.go_to(crossing.way)
        else:
            self.follower.stay(carrying, crossing.leaves)
        self.regrasp.reset()
        self._last = region
        self._searching = 0.0
        return self._goals(now)

    def _start_if_new(self, now: TaskTick) -> None:
        settings = now.settings
        if (settings.task, settings.starts) != self._task:
            self.reset()
            self._task = settings.task, settings.starts
        place = (settings.path[0], now.map_kinematics) if settings.path else None  # a place on the body is on every map
        if settings.task == "hold_point" and place != self._place:
            self._place = place
            self.target = None

    def _contact(self, regions: Sequence[ContactRegion]) -> ContactRegion | None:
        """Return the previous contact, else the strongest; on a path preferably the one on the path's next patch."""
        known = None if self._last is None else self._last.id
        found = next((region for region in regions if region.id == known), regions[0] if regions else None)
        target = self.follower.target
        if found is None or target is None or found.at.patch == target.patch:
            return found
        return self.follower.there(regions) or found

    def _search(self, now: TaskTick) -> list[ContactGoal]:
        """Return a goal without force that searches for a contact just lost; none for tasks that yield."""
        if self._last is None:
            return []
        task = now.settings.task
        goal = now.settings.force_goal
        self._searching += now.dt
        if task in ("retreat", "guide", "balance") or self._searching > SEARCH_TIME or not goal:
            self.lost = task not in ("retreat", "guide", "balance")
            self._last = None
            self.regrasp.reset()
            self.target = None if task in ("hold_point", "guide") else self.target
            return []
        now.limits.add(Limit(LimitKind.CONTACT_LOST))
        return [ContactGoal(replace(self._last, force=0.0), goal, presence=ContactPresence.LOST)]

    def _on_path(self, now: TaskTick, region: ContactRegion, new: bool) -> ContactGoal:
        follower = self.follower
        self.read_point = region.map_point
        region = self._contact_place.look(now, region)
        if follower.lay(now, region):
            self.regrasp.reset()
        elif new:
            follower.join(now, region)
        velocity = np.zeros(2)
        if self.regrasp.state is RegraspState.PLAN:
            self._look(now)
        else:
            velocity, crossing = follower.walk(now, region)
            if crossing is not None:
                self._take_over(crossing, region, now)
            elif follower.waits:
                now.limits.add(Limit(LimitKind.PATH_WAITS))
        self._add_uncertain_place(now, region, new=new)
        for limit in (follower.problem, follower.blocked):
            if limit is not None:
                now.limits.add(limit)
        self.target = follower.target
        return self._led(now, region, velocity)

    def _add_uncertain_place(self, now: TaskTick, region: ContactRegion, *, new: bool) -> None:
        """Add a limit if the skin locates the contact less accurately than the tolerance of the path."""
        known = region.place_error if new or self._place_error is None else self._place_error
        known += min(now.dt / _PLACE_TIME, 1.0) * (region.place_error - known)
        self._place_error = known
        located = round(_QUANTILE * known, 4)
        if located > PATH_TOLERANCE:
            now.limits.add(Limit(LimitKind.PLACE_UNCERTAIN, value=located, bound=PATH_TOLERANCE))

    def _take_over(self, crossing: PathCrossing, region: ContactRegion, now: TaskTick) -> None:
        if self.regrasp.request(crossing, region, now.regions, now.map_kinematics.map.skin, now.map_kinematics.pitch):
            self.follower.target = crossing.leaves
        else:
            links = now.map_kinematics.map.skin.link(crossing.leaves), now.map_kinematics.map.skin.link(crossing.enters)
            no_arm = Limit(LimitKind.REGRASP_FAILED, links, cause=RegraspFailure.NO_ARM)
            self.follower.stay(no_arm, crossing.leaves)

    def _look(self, now: TaskTick) -> None:
        """Hold the contact while a regrasp is planned."""
        self.regrasp.watch(now.regions, now.dt)
        crossing = self.regrasp.crossing
        limit = self.regrasp.limit
        if crossing is None or limit is None:
            return
        if self.regrasp.state is RegraspState.FAILED:
            self.follower.stay(limit, crossing.leaves)
            self.regrasp.reset()
        else:
            now.limits.add(limit)

    def _at_a_place(self, now: TaskTick, region: ContactRegion, new: bool) -> ContactGoal:
        path = now.settings.path
        guided = now.settings.task == "guide"
        if self.target is None or (new and guided):
            drawn = now.map_kinematics.map.to_body(np.array(path[0])) if path else region.at
            self.target = region.at if drawn is None or guided else drawn
            self._off_skin = drawn is None
        if self._off_skin:
            now.limits.add(Limit(LimitKind.POINT_OFF_SKIN))
        shear = _shear_goal(now, region)
        if guided and shear is not None:
            self.target = region.at
            return ContactGoal(region, now.settings.force_goal, shear=shear)
        goal = replace(self._led(now, region, np.zeros(2)), shear=shear)
        distance = now.map_kinematics.apart(self.target, region.at, now.configuration)
        if self.target.patch == region.at.patch or distance <= NEAR_PITCHES * now.map_kinematics.pitch:
            return goal
        names = tuple(now.map_kinematics.map.skin.patches[at.patch].name for at in (self.target, region.at))
        now.limits.add(Limit(LimitKind.CONTACT_ELSEWHERE, names))
        return ContactGoal(region, now.settings.force_goal)

    def _led(self, now: TaskTick, region: ContactRegion, velocity: FloatArray) -> ContactGoal:
        """Return the goal of a contact that moves to the target, also across seams."""
        assert self.target is not None
        jacobian = now.map_kinematics.jacobian(region.at, now.settings.jacobian, now.configuration)
        error = now.map_kinematics.error(self.target, region, jacobian, now.configuration)
        self.error = length(error)
        most = MOST_ERROR * now.map_kinematics.map.layout.placements[region.at.patch].scale
        if self.follower.leads_over:
            most = min(most, OVER * now.settings.path_speed / max(now.settings.position_gain, 1e-3))
        return ContactGoal(region, now.settings.force_goal, within_length(error, most), velocity, jacobian)


def _shear_goal(now: TaskTick, region: ContactRegion) -> ShearGoal | None:
    """Return the goal of the force along the skin in this task, at most what friction and its cap allow."""
    settings = now.settings
    if region.shear is None:
        return None
    if settings.task == "guide" and settings.shear_threshold < inf:
        return ShearGoal(np.zeros(2), settings.shear_threshold, ease=GUIDE_EASE)
    requested = settings.shear_goal
    if not requested or settings.task not in SHEAR_TASKS:
        return None
    possible = min(_MOST_USE * region.shear.friction * region.force, settings.max_shear)
    if possible < requested:
        now.limits.add(Limit(LimitKind.SHEAR_GOAL_LIMITED, (region.link,), value=requested, bound=possible))
    direction = settings.shear_direction
    return ShearGoal(min(requested, possible) * np.array([cos(direction), sin(direction)]))


def _report_unmeasured_shear(now: TaskTick) -> None:
    """Add a limit for contacts on skin without shear that the settings require."""
    settings = now.settings
    if settings.max_shear < inf or (settings.shear_goal and settings.task in SHEAR_TASKS):
        for region in now.regions:
            if region.shear is None:
                now.limits.add(Limit(LimitKind.SHEAR_UNMEASURED, (region.link,)))


def _balanced(now: TaskTick) -> list[ContactGoal]:
    regions = now.regions
    goal = now.settings.force_goal if len(regions) == 1 else float(np.mean([region.force for region in regions]))
    return [ContactGoal(region, goal) for region in regions]
