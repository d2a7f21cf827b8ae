"""Controller manager of a session: runs the selected controller with settings that may change at any time.

Controllers change without a jump. One safety monitor stops every controller. Gains are limited to what skin, arm and
contact allow (``gain_limits``), and the limits are reported.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import inf

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.controller_registry import build_controller, check_settings
from tactile_maps.control.controllers import Controller
from tactile_maps.control.force_loop.grip import GripGoal
from tactile_maps.control.force_loop.loop_stability import CONTACT_STIFFNESS, SensorTiming, assume_goal_where_saturated
from tactile_maps.control.gain_limits import GainLimiter
from tactile_maps.control.motion.approach_speed import ApproachSpeed, TaxelMotions
from tactile_maps.control.motion.command import ControlSettings, JointCommand, TaskReport
from tactile_maps.control.motion.joint_impedance import YieldingImpedance, joint_efforts, within_effort
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.observation import Observation
from tactile_maps.control.motion.unmeasured_force import (
    NO_FORCE,
    UnmeasuredForce,
    UnmeasuredForceMonitor,
)
from tactile_maps.control.path_following.clearance import Surroundings, nothing_around
from tactile_maps.control.task_control.monitors import (
    UNMEASURED_TOUCH,
    SafetyMonitor,
    greatest_point_speed,
    is_readable,
)
from tactile_maps.control.task_control.tasks import TaskManager
from tactile_maps.core.arrays import FloatArray, largest
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot

BLEND_TIME = 0.2
"""Time constant with which the remaining torque of the previous controller fades [s]."""
UNMEASURED_TIME = 0.5
"""Time for which a force that the skin does not measure must last before it is reported [s]."""
RESUME_TIME = 2.0
"""Time constant with which a controller takes over again after a stop [s], so that it presses slowly on a remaining
contact."""


class ControllerManager:
    """Computes joint commands from observations. Mutable; ``reset`` discards the past.

    A new controller starts as near as possible to the torque commanded before, and the rest of the difference fades.

    Args:
        robot: Robot to be controlled.
        map_: Map of the skin; ``use`` replaces it.
        settings: Initial settings; the property ``settings`` may be set at any time.
        surroundings: Returns the obstacles around the arm when a route is planned.
        stiffness: Stiffness of a contact of the cover [N/m], for the bound on impacts.

    Raises:
        SceneError: A setting is out of range; the previous settings stay.
    """

    def __init__(
        self,
        robot: Robot,
        map_: TactileMap,
        settings: ControlSettings,
        *,
        surroundings: Surroundings = nothing_around,
        stiffness: float = CONTACT_STIFFNESS,
    ) -> None:
        self._robot = robot
        self._stiffness = stiffness
        self._taxels = TaxelMotions.of(map_.skin)
        self._rest = robot.home
        self._map_kinematics = MapKinematics(map_)
        self._task_manager = TaskManager(robot, surroundings=surroundings)
        self._controllers: dict[str, Controller] = {}
        self._gain_limiter = GainLimiter(robot)
        self._grip = GripGoal()
        self._safety = SafetyMonitor(robot.joints)
        self._unmeasured = UnmeasuredForceMonitor(robot)
        self._pressed_bare = 0.0
        self._configuration = Configuration(robot)
        self._yielding = YieldingImpedance(self._configuration, self._safety.yield_speed)
        self._beyond: tuple[Limit, ...] = ()
        self._strained: tuple[str, ...] = ()
        self._efforts = joint_efforts(robot)
        self._settings = check_settings(settings)
        self._last: JointCommand | None = None
        self._fading: FloatArray | None = None
        self._blend_time = BLEND_TIME
        self._switched = False

    @property
    def settings(self) -> ControlSettings:
        """The current settings."""
        return self._settings

    @settings.setter
    def settings(self, settings: ControlSettings) -> None:
        check_settings(settings)
        if settings.controller != self._settings.controller:
            self._switched = True
            self._blend_time = BLEND_TIME
        self._settings = settings

    @property
    def rest(self) -> FloatArray:
        """(n,) the posture kept while nothing touches; the robot's home until it is set. A reset keeps it."""
        return self._rest

    @rest.setter
    def rest(self, posture: FloatArray) -> None:
        self._rest = posture
        for controller in self._controllers.values():
            controller.rest = posture

    @property
    def why_limited(self) -> tuple[Limit, ...]:
        """Limits of the current command, and settings that exceed what the skin allows; may be empty."""
        limits = ActiveLimits()
        for limit in self._controller.why_limited:
            limits.add(limit)
        if self._strained:
            limits.add(Limit(LimitKind.TORQUE_LIMIT, self._strained))
        return (*limits.found, *self._beyond)

    @property
    def readings(self) -> SensorTiming | None:
        """Timing of the skin's readings; None if unknown."""
        return self._gain_limiter.readings

    @readings.setter
    def readings(self, readings: SensorTiming | None) -> None:
        self._gain_limiter.readings = readings

    @property
    def report(self) -> TaskReport | None:
        """Progress of the task; None for a controller without a task."""
        return self._controller.report

    def use(self, map_: TactileMap) -> None:
        """Use another map of the same skin from now on; a path restarts."""
        self._map_kinematics = MapKinematics(map_)
        for controller in self._controllers.values():
            controller.use(self._map_kinematics)

    def prepare(self, tasks: Iterable[str], map_: TactileMap) -> None:
        """Build what tasks need and what takes too long for a control tick, before one of them becomes active.

        Args:
            tasks: Tasks that may become active next.
            map_: Map that is used with them.

        Raises:
            RobotError: MuJoCo rejects the robot's collision shapes.

        Cost: for ``follow_path`` 0.1 to 0.3 s, once for a robot, its skin and its surroundings; otherwise none.
        """
        if "follow_path" in tasks:
            self._task_manager.regrasp.prepare(map_.skin)

    def reset(self) -> None:
        """Discard the past; keep the settings."""
        self._task_manager.reset()
        self._gain_limiter.reset()
        self._grip.reset()
        self._safety.reset()
        self._unmeasured.reset()
        self._pressed_bare = 0.0
        self._last = None
        self._fading = None
        self._switched = False
        self._beyond = ()
        self._strained = ()
        for controller in self._controllers.values():
            controller.reset()

    def command(self, observation: Observation) -> JointCommand:
        """Return the joint command for the next ``observation.dt`` seconds."""
        posture = observation.posture
        velocity = observation.velocity
        unmeasured = self._unmeasured_force(observation)
        if self._must_stop(observation, unmeasured):
            command = self._yielding.about(self._safety.posture, velocity)
            command, _ = within_effort(command, posture, velocity, self._efforts)
            self._strained = ()
            self._last = command
            return command
        before = self._last.torque_at(posture, velocity) if self._switched and self._last is not None else None
        if before is not None:
            self._controller.start(posture, before)
        self._switched = False
        self._beyond = ()
        settings, contacts = self._effective_inputs(observation) if observation.readable else (self._settings, ())
        self._report_unmeasured(unmeasured, observation.dt)
        approach = self._approach_speed(observation.dt)
        command = self._controller.command(settings, replace(observation, contacts=contacts, approach=approach))
        if before is not None:
            self._fading = before - command.torque_at(posture, velocity)
        if self._fading is not None:
            command = replace(command, torque=command.torque + self._fading)
            self._fading = self._fading * np.exp(-observation.dt / self._blend_time)
            self._fading = self._fading if largest(self._fading) > 1e-6 else None
        command, excess = within_effort(command, posture, velocity, self._efforts)
        joints = zip(self._robot.joints, excess.tolist(), strict=True)
        self._strained = tuple(joint.name for joint, found in joints if found)
        self._last = command
        return command

    def _approach_speed(self, dt: float) -> ApproachSpeed | None:
        if self._settings.max_impact == inf:
            return None
        readings = self.readings
        latency = dt if readings is None else max(readings.period, dt) + readings.delay
        return ApproachSpeed(self._taxels, self._settings.max_impact, self._stiffness, latency)

    def _unmeasured_force(self, observation: Observation) -> UnmeasuredForce:
        self._configuration.update(observation.posture)
        if observation.torques is None:
            self._unmeasured.reset()
            return NO_FORCE
        readings = self.readings
        latency = 0.0 if readings is None else readings.period + readings.delay
        readable = [region for region in observation.contacts if is_readable(region)]
        return self._unmeasured.look(
            self._configuration, observation.velocity, readable, observation.torques, observation.dt, latency=latency
        )

    def _report_unmeasured(self, unmeasured: UnmeasuredForce, dt: float) -> None:
        """Add a limit for a bare part that presses on something, which no controller can relieve."""
        self._pressed_bare = self._pressed_bare + dt if unmeasured.force > UNMEASURED_TOUCH else 0.0
        if self._pressed_bare > UNMEASURED_TIME:
            limit = Limit(LimitKind.UNMEASURED_FORCE, (unmeasured.link,), value=unmeasured.force)
            self._beyond = (*self._beyond, limit)

    def _must_stop(self, observation: Observation, unmeasured: UnmeasuredForce) -> bool:
        """Return whether force, speed or the state of the skin stop the controller.

        An unreadable skin stops only controllers that need it: impedance does not read it, and hold force keeps its
        posture. One monitor serves all controllers, so that a stop continues when the controller changes.
        """
        max_force = self._settings.max_force
        if not self._controller.needs_skin:
            mismatch = observation.mismatch
            observation = replace(
                observation,
                contacts=tuple(region for region in observation.contacts if is_readable(region)),
                readable=observation.readable or self._safety.reason is None,
                mismatch=mismatch if mismatch is not None and mismatch.strongest > max_force else None,
            )
        safe = self._safety.check(
            max_force,
            observation,
            point_speed=greatest_point_speed(self._configuration, observation.velocity, observation.contacts),
            unmeasured=unmeasured,
        )
        if safe:
            return False
        self._controller.stop()
        self._blend_time = RESUME_TIME
        self._switched = True  # so that the controller starts from the torque of the stop
        self._fading = None
        self._beyond = () if self._safety.reason is None else (self._safety.reason,)
        return True

    def _effective_inputs(self, observation: Observation) -> tuple[ControlSettings, tuple[ContactRegion, ...]]:
        """Return settings and contacts for the controller, adapted to the skin's limits; store those limits."""
        settings = self._settings
        read = observation.contacts
        said = list[Limit]()
        if settings.controller != "impedance":
            readable = [region for region in read if is_readable(region)]
            goal, grip = self._grip.raised(settings, readable, self._configuration, observation.dt)
            if goal != settings.force_goal:
                settings = replace(settings, force_goal=goal)
            said += grip
            if self.readings is not None:
                read, plateau = assume_goal_where_saturated(read, goal, self.readings.highest)
                said += [Limit(LimitKind.SKIN_SATURATED)] if plateau else []
            commanded = None if self._last is None else self._last.posture
            settings, limits = self._gain_limiter.effective_settings(
                settings, observation.posture, observation.contacts, observation.dt, commanded=commanded
            )
            said += limits
            self._controller.hold_integrals(self._gain_limiter.stuck)
            if self._gain_limiter.oscillates:
                smallest = self._gain_limiter.exhausted
                kind = LimitKind.OSCILLATION_AT_SMALLEST_GAIN if smallest else LimitKind.OSCILLATION
                said.append(Limit(kind, value=settings.force_gain if self._gain_limiter.reduced else None))
        self._beyond = tuple(said)
        return settings, read

    @property
    def _controller(self) -> Controller:
        """Current controller, built at first use."""
        name = self._settings.controller
        if name not in self._controllers:
            self._controllers[name] = build_controller(name, self._robot, self._task_manager, self._map_kinematics)
            self._controllers[name].rest = self._rest
        return self._controllers[name]
