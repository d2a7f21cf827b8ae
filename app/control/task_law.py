"""A law with a task: contacts in, joint velocities out, integrated to a posture that a stiff impedance holds.

What is common to all of them is here: the contacts' Jacobians at the present posture, going home when nothing is
wanted, the bounds, the energy tank and the supervisor. How errors become velocities is the ``Rule``'s matter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf

import numpy as np

from app.arrays import FloatArray, readonly
from app.contacts.region import ContactRegion
from app.control.command import ControlSettings, JointCommand
from app.control.energy_tank import EnergyTank
from app.control.gains import joint_impedance
from app.control.map_sight import MapSight
from app.control.reference import PostureReference, slowed
from app.control.report import TaskReport
from app.control.rule import ArmState, Rule
from app.control.slip_watch import SlipWatch
from app.control.supervisor import Supervisor
from app.control.task_contact import TaskContact, Want
from app.control.task_keeper import TaskKeeper
from app.robots.configuration import Configuration
from app.robots.robot import Robot

STOP_FREQUENCY = 8.0
"""Natural frequency at which a stopped arm holds its place [rad/s]: softly, so that what presses it is relieved."""
LOST_SPEED = 0.1
"""Of a joint on the way home after a contact was lost that was wanted [rad/s]: at half a metre from the joint, 5 kg and
2e5 N/m then meet with 50 N, where ``HOME_SPEED`` meets with 300 (v sqrt(m k), theory page, 5.6)."""
_AT_HOME = 0.01
STAY = ("retreat", "guide")
"""Tasks after which the arm stays where it is."""
_HOME_SPEED = 0.2
"""At which joints that a task leaves free go back to rest, at most [rad/s]."""
_NO_MAP, _NO_VELOCITY = readonly(np.zeros((2, 3))), readonly(np.zeros(2))


class TaskLaw:
    """One rule at work. Mutable: wanted posture, and what rule, tank and supervisor remember.

    The velocity wanted is integrated to a posture that a stiff impedance holds. It is not fed forward as a torque too:
    against something hard that torque is force at once, and more of it than the error it came from.

    Args:
        robot: Whose joints; it may have none.
        rule: How errors become joint velocities.
        keeper: Of the task; shared by all laws, so that a task goes on when the law is changed.
        sight: Of the map.

    Attributes:
        tank: What contacts were given.

    Cost: 0.08 ms a command with one contact that may slide, 0.14 ms with one that is led to a place.
    """

    def __init__(self, robot: Robot, rule: Rule, keeper: TaskKeeper, sight: MapSight) -> None:
        self.rest, self.sight, self._rule, self._keeper = robot.home, sight, rule, keeper
        self._configuration = Configuration(robot)
        self._inertia = self._configuration.inertia()
        self._reference = PostureReference(robot, self._inertia)
        self._supervisor, self.tank, self._slip = Supervisor(), EnergyTank(), SlipWatch(1.5 * sight.pitch)
        self.reset()

    def reset(self) -> None:
        """No contact known; the posture found at the next command is where it starts from."""
        self.why_limited: tuple[str, ...] = ()
        self._rule.reset()
        self._reference.reset()
        self._supervisor.reset()
        self.tank.reset()
        self._slip.reset()
        self._speed = np.zeros_like(self.rest)

    def start(self, posture: FloatArray, torque: FloatArray) -> None:
        """Without history, from the posture at which this law asks for ``torque`` (n,) of an arm at rest."""
        self.reset()
        self._reference.start(posture, torque)

    def command(
        self,
        settings: ControlSettings,
        posture: FloatArray,
        velocity: FloatArray,
        regions: Sequence[ContactRegion],
        dt: float,
    ) -> JointCommand:
        """Do the task for a tick, or stand still and say why."""
        if not self._supervisor.check(settings.max_force, posture, velocity, regions, dt):
            return self._stopped(posture)
        limits: list[str] = []
        self._configuration.update(posture)
        start = self._reference.from_where(posture)
        wants = self._keeper.wants(settings, regions, self.sight, self._configuration, dt, limits)
        carried = self._keeper.carrier.speed(start, self.rest, self._configuration, dt)
        if carried is not None:
            self._rule.reset()
            self._reference.stand()
            speed = slowed(carried, limits)
        elif wants:
            self._reference.stand()
            speed = self._work(settings, wants, regions, start, velocity, dt, limits)
        else:
            speed = self._idle(settings, start, dt, limits)
        self._speed = speed
        command = self._reference.move(posture, speed, dt, limits)
        self.why_limited = tuple(dict.fromkeys(limits))
        return command

    @property
    def report(self) -> TaskReport:
        """How the task goes."""
        keeper, tank = self._keeper, self.tank
        return replace(keeper.report, energy=tank.given, tank=tank.level)

    def _stopped(self, posture: FloatArray) -> JointCommand:
        self.why_limited = (self._supervisor.reason,)
        self._rule.reset()
        self._keeper.let_go()
        self._reference.reset()
        self._speed = np.zeros_like(self.rest)
        return joint_impedance(self._inertia, self._supervisor.posture, frequency=STOP_FREQUENCY, damping_ratio=1.0)

    def _idle(self, settings: ControlSettings, start: FloatArray, dt: float, limits: list[str]) -> FloatArray:
        self._rule.reset()
        self.tank.reset()
        if settings.task in STAY:
            return np.zeros_like(start)
        if not self._keeper.lost:
            return self._reference.home_speed(start, self.rest, dt)
        if np.abs(self.rest - start).max(initial=0.0) > _AT_HOME:
            limits.append("coming home slowly, since what it lost may stand in the way")
        return self._reference.home_speed(start, self.rest, dt, most=LOST_SPEED)

    def _work(
        self,
        settings: ControlSettings,
        wants: Sequence[Want],
        regions: Sequence[ContactRegion],
        start: FloatArray,
        velocity: FloatArray,
        dt: float,
        limits: list[str],
    ) -> FloatArray:
        contacts = tuple(self._contact(settings, want) for want in wants)
        wanted = {contact.id for contact in contacts}
        others = tuple(self._contact(settings, Want(r, r.force)) for r in regions if r.id not in wanted)
        home = np.minimum(np.maximum(self.rest - start, -_HOME_SPEED), _HOME_SPEED)
        arm = ArmState(start, home, self._speed, self._reference, contacts + others, dt)
        contacts = self._unless_stuck(settings, contacts, wants, dt, limits)
        # What the tank slows down is no force that an integral could bring.
        asked = settings if self.tank.share == 1.0 else replace(settings, integral_time=inf)
        levels = self._rule.levels(asked, contacts, arm, limits)
        speed = self._rule.solve(levels, settings, contacts, arm, limits)
        return self._within_energy(contacts, speed, velocity, dt, limits)

    def _contact(self, settings: ControlSettings, want: Want) -> TaskContact:
        region, pose = want.region, self._configuration.pose(want.region.link)
        to_map = want.to_map
        if to_map is None and want.error is not None:
            to_map = self.sight.jacobian(region.at, settings.jacobian, self._configuration)
        return TaskContact(
            id=region.id,
            force=region.force,
            force_error=want.force - region.force,
            normal=pose.rotation.dot(self.sight.normal(region, settings.jacobian)),
            point=pose.points(region.point),
            move=self._configuration.jacobian(region.link, region.point),
            to_map=_NO_MAP if to_map is None else to_map,
            error=want.error,
            velocity=_NO_VELOCITY if want.velocity is None else want.velocity,
        )

    def _unless_stuck(
        self,
        settings: ControlSettings,
        contacts: tuple[TaskContact, ...],
        wants: Sequence[Want],
        dt: float,
        limits: list[str],
    ) -> tuple[TaskContact, ...]:
        """The same contacts; one that does not come is let slide."""
        first = contacts[0]
        if first.error is None:
            return contacts
        asked = settings.position_gain * first.error + first.velocity
        tried = -first.to_map @ (first.move @ self._speed)
        held_up = self._slip.look(
            first.id, wants[0].region.map_point, first.error, asked, tried, dt, target=self._keeper.target
        )
        if not held_up:
            return contacts
        limits.append(held_up)
        return (replace(first, error=None), *contacts[1:])

    def _within_energy(
        self, contacts: Sequence[TaskContact], speed: FloatArray, velocity: FloatArray, dt: float, limits: list[str]
    ) -> FloatArray:
        """Count what contacts are given, and slow down what would give more than the tank holds."""
        effort = np.zeros_like(speed)  # joint torques with which the arm presses on its contacts
        for contact in contacts:
            effort += contact.force * contact.outward
        self.tank.flow(float(effort.dot(velocity)), float(self._reference.impedance.damping.dot(velocity**2)), dt)
        gives = effort.dot(speed) > 0
        if not gives or self.tank.share == 1.0:
            return speed
        limits.append(f"energy given to the contact, {self.tank.given:.1f} J")
        return speed * self.tank.share
