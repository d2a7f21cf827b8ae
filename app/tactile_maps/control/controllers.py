"""The eight controllers and their common interface; ``controller_registry`` lists them by name.

* Impedance: the arm as a spring to its rest posture; it yields to a touch and returns (Hogan 1985, in joint space).
* Hold force: the arm follows or retreats from a touch so that the contact force stays at a goal, and returns to rest
  afterwards. It is an admittance along the contact's normal: velocity is proportional and integral to the force error,
  so that a finger that keeps advancing is held at the goal without steady-state error. (Against a spring k the loop is
  of second order: natural frequency sqrt(gain k / integral_time), damping ratio half of sqrt(gain k integral_time).)
  Damped least squares turn the velocity of the contact point into joint velocity; the desired posture is its integral,
  held by a stiff joint impedance.
* Six controllers with a task (``TaskController``): contacts in, joint velocities out, integrated to a posture that a
  stiff impedance holds. They share contact Jacobians at the current posture, the return to rest, bounds and the energy
  tank, and differ in their ``ControlScheme`` (``schemes``): how errors become joint velocities.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf
from typing import Protocol

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.force_loop.normal_motion import (
    ENOUGH_TILT,
    LEAST_TILT,
    RisingForces,
    bearable_tilt,
    slow_aside,
)
from tactile_maps.control.motion.command import ControlSettings, JointCommand, TaskReport
from tactile_maps.control.motion.joint_impedance import (
    MAX_JOINT_SPEED,
    MAX_POINT_SPEED,
    MAX_SLIDE_SPEED,
    JointImpedance,
    PostureReference,
    limit_joint_speed,
)
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.observation import Observation, TaskTick
from tactile_maps.control.motion.task_priority import (
    ArmState,
    ContactGoal,
    ContactKey,
    ContactPresence,
    ControlScheme,
    PriorityLevel,
    TaskContact,
    single_level,
    solve_within_limits,
)
from tactile_maps.control.path_following.nearest_posture import TargetReach
from tactile_maps.control.path_following.slide_observer import COARSE, SOFT, SlideObserver, YieldObserver, observer_rate
from tactile_maps.control.task_control.contact_selection import ContactSelection, ControlledContact, ReliefMonitor
from tactile_maps.control.task_control.monitors import EnergyTank, StallDetector, is_readable, mismatch_limit
from tactile_maps.control.task_control.schemes import (
    AdmittanceScheme,
    ForceServo,
    HybridScheme,
    ParallelScheme,
    PriorityScheme,
    ProjectionScheme,
    QuadraticProgramScheme,
)
from tactile_maps.control.task_control.tasks import TaskManager
from tactile_maps.core.arrays import FloatArray, any_true, largest, length, readonly
from tactile_maps.maps.model.jacobian import least_norm_motion
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot


class Controller(Protocol):
    """A controller. Mutable; ``reset`` discards the past.

    Attributes:
        rest: (n,) posture held while nothing touches, and returned to: home until it is set.
    """

    rest: FloatArray

    @property
    def needs_skin(self) -> bool:
        """True if the arm must stop where the skin cannot be read; False if the controller handles this itself."""

    @property
    def why_limited(self) -> tuple[Limit, ...]:
        """Limits of the current command; empty if there are none."""

    @property
    def report(self) -> TaskReport | None:
        """Progress of the task; None for a controller without a task."""

    def use(self, map_kinematics: MapKinematics) -> None:
        """Use an edited map from now on."""

    def reset(self) -> None:
        """Discard the past; ``rest`` stays."""

    def stop(self) -> None:
        """Discard the contact. Called at every tick at which the safety monitor stops the arm."""

    def hold_integrals(self, contacts: frozenset[int]) -> None:
        """Stop the growth of integrals of these contacts, whose points do not make the commanded motion."""

    def start(self, posture: FloatArray, torque: FloatArray) -> None:
        """Start without history after another controller, as near as possible to its torque.

        Args:
            posture: (n,) measured posture.
            torque: (n,) torque commanded before, without damping [N m].
        """

    def command(self, settings: ControlSettings, observation: Observation) -> JointCommand:
        """Return the joint command for the next ``observation.dt`` seconds.

        Args:
            settings: Current settings.
            observation: State of robot and skin. Without a readable skin ``contacts`` is empty.
        """


class BuiltInController:
    """Base of the built-in controllers: one without task, integrals and map, that does not need the skin. Mutable.

    Args:
        robot: Robot to be controlled; it may have no joints.
    """

    why_limited: tuple[Limit, ...] = ()
    report: TaskReport | None = None
    needs_skin = False

    def __init__(self, robot: Robot) -> None:
        self.rest = robot.home
        self._configuration = Configuration(robot)
        self._reference = PostureReference(robot, self._configuration)
        self._relief = ReliefMonitor()
        # A metre of a slide counts as the angle of a hinge that takes as long.
        self._shares = np.array([MAX_SLIDE_SPEED / MAX_JOINT_SPEED if one.slide else 1.0 for one in robot.joints])

    def use(self, map_kinematics: MapKinematics) -> None:
        """Do nothing: the map is not used."""

    def reset(self) -> None:
        """Discard contacts and the desired posture; the next command starts from the measured one."""
        self.why_limited = ()
        self._reference.reset()
        self._relief.reset()

    def stop(self) -> None:
        """Discard all contacts."""
        self.reset()

    def hold_integrals(self, contacts: frozenset[int]) -> None:
        """Do nothing: there are no integrals."""

    def start(self, posture: FloatArray, torque: FloatArray) -> None:
        """Start without history at the posture for which this controller commands ``torque`` (n,) to an arm at rest."""
        self.reset()
        self._configuration.update(posture)
        self._reference.start(posture, torque)

    def _move(
        self, observation: Observation, speed: FloatArray, limits: ActiveLimits
    ) -> tuple[JointCommand, FloatArray]:
        """Return the command after one tick of ``speed`` (n,), and the speed (n,) within the bound of an approach."""
        safe = speed
        if observation.approach is not None:
            safe = observation.approach.limited(self._configuration, speed, limits)
        command = self._reference.move(
            observation.posture, safe, observation.dt, limits, velocity=observation.velocity, slowed=safe is not speed
        )
        self.why_limited = limits.found
        return command, safe


class ImpedanceController(BuiltInController):
    """Holds the rest posture with a stiffness and damping. Contacts are not read; the arm yields to them."""

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot)
        self._max_speed = np.array([joint.max_speed for joint in robot.joints])

    def start(self, posture: FloatArray, torque: FloatArray) -> None:
        """Do nothing: the command depends on the rest posture only."""

    def command(self, settings: ControlSettings, observation: Observation) -> JointCommand:
        """Hold the rest posture with the gains of the current posture."""
        posture = observation.posture
        self._configuration.update(posture)
        impedance = JointImpedance(
            self._configuration, frequency=settings.stiffness, damping_ratio=settings.damping_ratio
        )
        deviation = impedance.deviation()
        self.why_limited = () if deviation is None else (deviation,)
        # The spring moves a joint no faster than its stiffness times the deflection over its damping.
        most = self._max_speed * impedance.damping / impedance.stiffness
        aim = np.minimum(np.maximum(self.rest, posture - most), posture + most)
        if any_true(aim != self.rest):
            self.why_limited += (Limit(LimitKind.JOINT_SPEED),)
        return impedance.about(aim)


class HoldForceController(BuiltInController):
    """Keeps the strongest contact, and all others above the goal, at the goal force. Mutable.

    Args:
        robot: Robot to be controlled; it may have no joints.

    Cost: 50 µs a command in contact.
    """

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot)
        self._selection = ContactSelection()
        self.reset()

    def reset(self) -> None:
        """Discard contacts, integrals and the desired posture."""
        super().reset()
        self._servo = ForceServo(MAX_POINT_SPEED)
        self._selection.reset()

    def hold_integrals(self, contacts: frozenset[int]) -> None:
        """Stop the growth of integrals of these contacts."""
        self._servo.stuck = contacts

    def command(self, settings: ControlSettings, observation: Observation) -> JointCommand:
        """Retreat along the inward normals of contacts that press too hard; advance if the strongest is too weak."""
        limits = ActiveLimits()
        posture = observation.posture
        dt = observation.dt
        regions = observation.contacts
        self._configuration.update(posture)
        start = self._reference.start_posture(posture)
        kept, left_out = self._selected(settings, regions) if observation.readable and regions else ([], [])
        self._servo.keep((region.id, ContactPresence.FELT) for region in kept)
        if not observation.readable or not all(is_readable(region) for region in kept):
            limits.add(Limit(LimitKind.SKIN_UNREADABLE))
            speed = np.zeros_like(start)
        elif observation.mismatch is not None:
            limits.add(mismatch_limit(observation.mismatch))
            speed = np.zeros_like(start)
        elif regions:
            self._reference.stop_homing()
            speed = self._follow(settings, start, kept, left_out, dt, limits)
        else:
            speed = self._reference.home_speed(start, self.rest, dt)
        return self._move(observation, speed, limits)[0]

    def _selected(
        self, settings: ControlSettings, regions: Sequence[ContactRegion]
    ) -> tuple[list[ContactRegion], list[ContactRegion]]:
        """Return the controlled contacts, and others above the goal that the joints cannot relieve in addition."""
        unrelieved = self._relief.unrelieved
        first = next((region for region in regions if region.id not in unrelieved), regions[0])
        others = self._selection.others(first, regions, settings.force_goal)
        kept = [first, *(region for region in others if region.id not in unrelieved)]
        return kept, [region for region in others if region.id in unrelieved]

    def _follow(
        self,
        settings: ControlSettings,
        start: FloatArray,
        regions: Sequence[ContactRegion],
        left_out: Sequence[ContactRegion],
        dt: float,
        limits: ActiveLimits,
    ) -> FloatArray:
        self._servo.held = self._reference.bounded
        levels = []
        controlled = []
        moves = []
        for region in (*regions, *left_out):
            normal = self._configuration.pose(region.link).rotation.dot(region.link_normal)
            move = self._configuration.jacobian(region.link, region.link_position)
            row = normal.dot(move)
            controlled.append(ControlledContact(region, settings.force_goal, row, left_out=region in left_out))
            if region in left_out:
                continue
            error = settings.force_goal - region.force
            push = self._servo.push(settings, (region.id, ContactPresence.FELT), error, dt, limits)
            tilt = bearable_tilt(row * self._shares, move * self._shares)
            if tilt >= LEAST_TILT:
                levels.append(PriorityLevel(row[None], np.array((push,)), normal[None]))
            else:
                levels.append(PriorityLevel(move, push * normal, np.eye(3)))
            moves.append((move, normal, tilt))
        speed = solve_within_limits(single_level(levels), self._reference, start, limits)
        for move, normal, tilt in moves:
            speed = slow_aside(move, normal, tilt, speed, limits)
        self._relief.look(controlled, speed, self._reference.max_speed, settings.force_gain, dt, limits)
        return speed


LOST_SPEED = 0.1
"""Joint speed on the return to rest after a desired contact was lost [rad/s]. At half a metre from the joint, 5 kg and
2e5 N/m then collide with 50 N instead of 300 N at ``HOME_SPEED`` (v sqrt(m k), theory page, 5.6)."""
_AT_HOME = 0.01
ALL_CONTACTS = ("balance", "retreat")
"""Tasks in which no contact has precedence."""
EASE_TIME = 0.3
"""Time constant with which the arm yields more to a hand that keeps pulling [s]."""
STAY = ("retreat", "guide")
"""Tasks after which the arm keeps its posture."""
_HOME_SPEED = 0.2
"""Largest speed at which joints that a task leaves free return to rest [rad/s]."""
_NO_MAP = readonly(np.zeros((2, 3)))
_NO_VELOCITY = readonly(np.zeros(2))


class TaskController(BuiltInController):
    """Runs a control scheme for the contacts of a task. Mutable.

    The desired velocity is integrated to a posture that a stiff impedance holds. It is not also fed forward as a
    torque: against a stiff object that torque becomes force immediately, larger than the error it came from.

    Args:
        robot: Robot to be controlled; it may have no joints.
        scheme: Computes joint velocities from errors.
        task_manager: Task manager, shared by all controllers so that a task continues when the controller is changed.
        map_kinematics: Kinematics of the map.

    Attributes:
        tank: Energy given to contacts.

    Cost: 0.08 ms a command with one contact that may slide, 0.14 ms with one that is moved to a position.
    """

    needs_skin = True

    def __init__(
        self, robot: Robot, scheme: ControlScheme, task_manager: TaskManager, map_kinematics: MapKinematics
    ) -> None:
        super().__init__(robot)
        self.map_kinematics = map_kinematics
        self._scheme = scheme
        self._task_manager = task_manager
        self.tank = EnergyTank()
        self._stall = StallDetector(1.5 * map_kinematics.pitch)
        self._reach = TargetReach(robot)
        self._slide = SlideObserver()
        self._yield = YieldObserver()
        self.reset()

    def reset(self) -> None:
        """Discard contacts, integrals and the desired posture."""
        super().reset()
        self._scheme.reset()
        self.tank.reset()
        self._stall.reset()
        self._reach.reset()
        self._forget_contact()
        self._slippery: dict[int, float] = {}
        self._rising = RisingForces()
        self._stuck: frozenset[int] = frozenset()
        self._speed = np.zeros_like(self.rest)

    def hold_integrals(self, contacts: frozenset[int]) -> None:
        """Stop the growth of integrals of these contacts."""
        self._stuck = contacts

    def command(self, settings: ControlSettings, observation: Observation) -> JointCommand:
        """Perform the task for one tick. All regions are readable: the manager stops the arm otherwise."""
        posture = observation.posture
        dt = observation.dt
        self._configuration.update(posture)
        limits = ActiveLimits()
        start = self._reference.start_posture(posture)
        now = TaskTick(settings, observation.contacts, self.map_kinematics, self._configuration, dt, limits)
        goals = self._task_manager.goals(now)
        carried = self._task_manager.regrasp.speed(start, self.rest, self._configuration, dt)
        if carried is not None:
            self._scheme.reset()
            self._forget_contact()
            self._reference.stop_homing()
            speed = limit_joint_speed(carried, self._reference.max_speed, limits)
        elif goals:
            self._reference.stop_homing()
            speed = self._work(now, goals, start, observation.velocity)
        else:
            speed = self._idle(now, start)
        command, self._speed = self._move(observation, speed, limits)
        return command

    def use(self, map_kinematics: MapKinematics) -> None:
        """Use this map from now on; a path starts again."""
        self.map_kinematics = map_kinematics

    @property
    def report(self) -> TaskReport:  # type: ignore[override]  # computed on request
        """Progress of the task."""
        report = self._task_manager.report(self.tank)
        controlled = tuple(one for one in report.controlled if one not in self._relief.unrelieved)
        return replace(report, controlled=controlled)

    def stop(self) -> None:
        """Discard the contact; the task continues from its current state."""
        self.why_limited = ()
        self._scheme.reset()
        self._forget_contact()
        self._task_manager.let_go()
        self._reference.reset()
        self._speed = np.zeros_like(self.rest)

    def _idle(self, now: TaskTick, start: FloatArray) -> FloatArray:
        self._scheme.reset()
        self.tank.reset()
        self._relief.reset()
        self._forget_contact()
        self._slippery.clear()
        if now.settings.task in STAY:
            return np.zeros_like(start)
        if not self._task_manager.lost:
            return self._reference.home_speed(start, self.rest, now.dt)
        if largest(self.rest - start) > _AT_HOME:
            now.limits.add(Limit(LimitKind.SLOW_HOMING))
        return self._reference.home_speed(start, self.rest, now.dt, most=LOST_SPEED)

    def _work(self, now: TaskTick, goals: Sequence[ContactGoal], start: FloatArray, velocity: FloatArray) -> FloatArray:
        settings = now.settings
        limits = now.limits
        together = settings.task in ALL_CONTACTS
        unrelieved = frozenset() if together else self._relief.unrelieved
        left_out = [goal for goal in goals[1:] if goal.region.id in unrelieved]
        goals = [goals[0], *(goal for goal in goals[1:] if goal.region.id not in unrelieved)]
        contacts = tuple(self._contact(settings, goal) for goal in goals)
        ids = {contact.id for contact in contacts}
        others = tuple(self._contact(settings, ContactGoal(one, one.force)) for one in now.regions if one.id not in ids)
        outward = {contact.id: contact.outward for contact in contacts + others}
        most = self._reference.slow_speed(_HOME_SPEED)
        home = np.minimum(np.maximum(self.rest - start, -most), most)
        arm = ArmState(start, home, self._speed, self._reference, contacts + others, now.dt, self._stuck)
        pressed = [(c.id, c.force, c.force + c.force_error, c.tilt) for c in contacts]
        if self._rising.look(pressed, settings.max_force):
            limits.add(Limit(LimitKind.FORCE_RISES))
            self._scheme.reset()
            return np.zeros_like(start)
        read = self._task_manager.read_point
        point = goals[0].region.map_point if read is None else read
        contacts = self._eased(self._led(now, contacts, point, velocity), now.dt)
        # An integral cannot add force where the tank slows the motion down, or where contacts oppose each other.
        free = self.tank.share == 1.0 and not (together and self._relief.unrelieved)
        effective = settings if free else replace(settings, integral_time=inf)
        levels = self._scheme.levels(effective, contacts, arm, limits)
        speed = self._scheme.solve(levels, settings, contacts, arm, limits)
        for contact in (one for one in contacts if one.tilt < ENOUGH_TILT):
            aside = length(contact.along(settings, MAX_POINT_SPEED) + contact.made_up)
            speed = slow_aside(contact.move, contact.normal, contact.tilt, speed, limits, desired=aside)
        speed = self._within_energy(now, contacts, speed, velocity)
        controlled = [
            ControlledContact(goal.region, goal.force, outward[goal.region.id], left_out=goal in left_out)
            for goal in (*goals, *left_out)
        ]
        self._relief.look(controlled, speed, self._reference.max_speed, settings.force_gain, now.dt, limits)
        return speed

    def _contact(self, settings: ControlSettings, goal: ContactGoal) -> TaskContact:
        region = goal.region
        pose = self._configuration.pose(region.link)
        normal = pose.rotation.dot(self.map_kinematics.normal(region, settings.jacobian))
        move = self._configuration.jacobian(region.link, region.link_position)
        tilt = self._tilt(region.id, normal.dot(move), move)
        to_map = goal.to_map
        if to_map is None and (goal.error is not None or goal.shear is not None):
            to_map = self.map_kinematics.jacobian(region.at, settings.jacobian, self._configuration)
        shear = region.shear if goal.presence is ContactPresence.FELT else None
        return TaskContact(
            id=region.id,
            force=region.force,
            force_error=goal.force - region.force,
            normal=normal,
            point=pose.points(region.link_position),
            move=move,
            to_map=_NO_MAP if to_map is None else to_map,
            error=goal.error,
            velocity=_NO_VELOCITY if goal.velocity is None else goal.velocity,
            curvature=0.0
            if goal.velocity is None or to_map is None
            else self.map_kinematics.curvature(region, goal.velocity, to_map),
            presence=goal.presence,
            tilt=tilt,
            straight=tilt < LEAST_TILT,
            shear=np.zeros(3) if shear is None else pose.rotation.dot(shear.force),
            shear_goal=None if shear is None else goal.shear,
            friction=0.0 if shear is None else shear.friction,
        )

    def _tilt(self, contact: int, outward: FloatArray, move: FloatArray) -> float:
        """Return the tolerated error of a contact's normal [rad]: the smallest since it began, if that was small."""
        tilt = min(bearable_tilt(outward * self._shares, move * self._shares), self._slippery.get(contact, inf))
        if tilt < LEAST_TILT:
            self._slippery[contact] = tilt
        return tilt

    def _forget_contact(self) -> None:
        self._lasting: tuple[ContactKey, FloatArray] | None = None
        self._points: dict[int, FloatArray] = {}
        self._forget_slide()

    def _forget_slide(self) -> None:
        self._slide.reset()
        self._yield.reset()

    def _eased(self, contacts: tuple[TaskContact, ...], dt: float) -> tuple[TaskContact, ...]:
        """Return the contacts; the first yields more to a force along the skin that lasts."""
        first = contacts[0]
        if first.shear_goal is None or first.shear_goal.ease == 1.0:
            self._lasting = None
            return contacts
        key, before = self._lasting or (first.key, np.zeros(3))
        before = before if key == first.key else np.zeros(3)
        lasting = before + min(dt / EASE_TIME, 1.0) * ((first.shear_goal.ease - 1.0) * first.excess - before)
        self._lasting = first.key, lasting
        return (replace(first, lasting=lasting), *contacts[1:])

    def _friction_yield(self, contact: TaskContact, goal: float) -> float:
        """Return the way that the joints yield along the skin to a friction equal to the force ``goal`` [m]."""
        rows = contact.map_axes.dot(contact.move)
        return goal * float(np.linalg.norm((rows / self._reference.impedance.stiffness).dot(rows.T), 2))

    def _out_of_reach(self, point: FloatArray) -> Limit | None:
        """Return a limit if no posture was found that brings the target to the touched ``point`` (3,)."""
        target = self._task_manager.target
        if target is None or self._stall.reason is None or self._stall.reason.kind is not LimitKind.NO_APPROACH:
            return None
        skin = self.map_kinematics.map.skin
        posture = self._configuration.posture
        short_by = self._reach.short_by(target, skin.link(target), skin.position(target), point, posture)
        return None if short_by is None else Limit(LimitKind.OUT_OF_REACH, value=short_by)

    def _led(
        self, now: TaskTick, contacts: tuple[TaskContact, ...], point: FloatArray, velocity: FloatArray
    ) -> tuple[TaskContact, ...]:
        """Return the contacts, the first with its missing velocity on a path, or free to slide if it is stuck."""
        settings = now.settings
        first = contacts[0]
        if first.error is None:
            self._forget_slide()
            return contacts
        requested = settings.position_gain * first.error + first.velocity
        tried = -first.to_map @ (first.move @ self._speed)
        bends = self._friction_yield(first, settings.force_goal) if settings.task == "follow_path" else 0.0
        soft = bends > SOFT
        stalled = self._stall.look(
            first.id,
            point,
            first.error,
            requested,
            tried,
            now.dt,
            target=self._task_manager.target,
            yielding=2 * bends if soft else 0.0,
        )
        if stalled is not None:
            now.limits.add(self._out_of_reach(first.point) or stalled)
            self._forget_slide()
            return (replace(first, error=None), *contacts[1:])
        felt = first.presence is ContactPresence.FELT
        if settings.task != "follow_path" or not felt:
            return contacts
        if soft:
            moved = -first.to_map @ (first.move @ velocity)
            added = -least_norm_motion(first.to_map, self._yield.look(tried, moved, now.dt))
            first = replace(first, made_up=added - added.dot(first.normal) * first.normal)
            tried = moved
        if self.map_kinematics.pitch > COARSE:
            return (first, *contacts[1:])
        rate = observer_rate(settings.position_gain, settings.path_speed, self.map_kinematics.pitch)
        missing = self._slide.look(
            first.id, point, tried, now.dt, rate=rate, speed=settings.path_speed, curvature=first.curvature
        )
        return (replace(first, velocity=first.velocity + missing), *contacts[1:])

    def _within_energy(
        self, now: TaskTick, contacts: Sequence[TaskContact], speed: FloatArray, velocity: FloatArray
    ) -> FloatArray:
        """Count the energy given to contacts, and slow down motion that would give more than the tank contains.

        A force along the skin does its work along the way of the contact in the world, which is that of the object: an
        object that slides on the skin does not move with it. Along the normal both move together.
        """
        effort = np.zeros(len(speed))  # joint torques with which the arm presses on its contacts
        given = 0.0
        for contact in contacts:
            effort += contact.force * contact.outward
            moved = contact.point - self._points.get(contact.id, contact.point)
            across = moved - contact.normal.dot(moved) * contact.normal
            given -= float(contact.shear.dot(across)) / now.dt
        self._points = {contact.id: contact.point for contact in contacts}
        given += float(effort.dot(velocity))
        effort -= sum((contact.shear.dot(contact.move) for contact in contacts), np.zeros(len(speed)))
        self.tank.flow(given, float(self._reference.impedance.damping.dot(velocity**2)), now.dt)
        gives = effort.dot(speed) > 0
        if not gives or self.tank.share == 1.0:
            return speed
        now.limits.add(Limit(LimitKind.ENERGY_TANK, value=self.tank.given))
        return speed * self.tank.share


CONTROL_SCHEMES: dict[str, Callable[[], ControlScheme]] = {
    "admittance": AdmittanceScheme,
    "hybrid": HybridScheme,
    "parallel": ParallelScheme,
    "projection": ProjectionScheme,
    "priority": PriorityScheme,
    "qp": QuadraticProgramScheme,
}
"""Control schemes of the controllers with a task, by name."""
