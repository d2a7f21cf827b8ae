"""Monitors of a controller with a task: what is unsafe, what does not come along, and what energy contacts were given.

``SafetyMonitor`` stops when force or speed leave what is safe, and says why. ``StallDetector`` notices that a contact
does not come along the map as the arm wants it to, and why. ``EnergyTank`` (Franken et al. 2011): what an arm may give
to what it touches is what it was given, and what its damping took.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.force_estimation.wrench_consistency import WrenchMismatch
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.control.motion.observation import Observation
from tactile_maps.control.motion.unmeasured_force import NO_FORCE, UnmeasuredForce
from tactile_maps.core.arrays import FloatArray, all_finite, largest, length
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Joint

STOP_SPEED = 3.0
STOP_SLIDE_SPEED = 0.5
"""Joint speed that stops the arm, of a hinge [rad/s] and of a slide [m/s]; twice what controllers request."""
STOP_SPEED_MARGIN = 1.5
"""A joint stops the arm at this multiple of the speed that its model allows, if that is less."""
STOP_POINT_SPEED = 1.0
"""Greatest speed of a touched point [m/s]; four times the greatest that controllers request."""
YIELD_TIME = 0.5
"""Time constant with which a stopped arm gives way to what still touches it [s]."""
YIELD_SPEED = 0.6
YIELD_SLIDE_SPEED = 0.1
"""Largest speed at which a stopped arm gives way, of a hinge [rad/s] and of a slide [m/s]; faster motion is damped."""
UNMEASURED_TOUCH = 3.0
"""Force that the skin does not measure [N] above which something still touches a stopped arm."""
QUIET = 1.0
"""Nothing must have touched for so long before the controller goes on [s]."""
AGREED = 0.2
"""One contact must have explained the wrench for so long before the controller goes on [s]."""


class SafetyMonitor:
    """Decides between going on and standing. Mutable; ``reset`` lets the controller go on.

    It goes on by itself once nothing has touched for ``QUIET``; where several contacts were read as one wrench, once
    one of them has explained it for ``AGREED``.

    Args:
        joints: The robot's joints, in the order of a posture.

    Attributes:
        reason: Why it stopped; None while the controller goes on.
        posture: (n,) to hold: where it stopped, and from there to where the arm is pressed while something touches, at
            most at ``yield_speed``.
        yield_speed: (n,) largest speed at which a stopped arm gives way [rad/s, or m/s for a slide].
    """

    def __init__(self, joints: Sequence[Joint]) -> None:
        self._joints = tuple(joints)
        self._stop_speed = stop_speeds(joints)
        usual = (YIELD_SLIDE_SPEED if joint.slide else YIELD_SPEED for joint in joints)
        self.yield_speed = np.array([min(most, joint.max_speed) for most, joint in zip(usual, joints, strict=True)])
        self.reset()

    def reset(self) -> None:
        """Nothing is wrong."""
        self.reason: Limit | None = None
        self._quiet = 0.0
        self.posture: FloatArray = np.zeros(0)

    def check(
        self,
        max_force: float,
        observation: Observation,
        *,
        point_speed: float = 0.0,
        unmeasured: UnmeasuredForce = NO_FORCE,
    ) -> bool:
        """Return True if the controller may continue.

        Args:
            max_force: Largest force of any contact [N].
            observation: State of robot and skin.
            point_speed: Largest speed of a contact point [m/s].
            unmeasured: Force that the skin does not measure.
        """
        posture = observation.posture
        regions = observation.contacts
        mismatch = observation.mismatch
        dt = observation.dt
        touched = bool(regions) or unmeasured.force > UNMEASURED_TOUCH
        unreadable = None if observation.readable else Limit(LimitKind.STOPPED_UNREADABLE)
        reason = (
            unreadable
            or _force_danger(max_force, regions)
            or self._speed_danger(observation.velocity, point_speed)
            or _hidden_force(max_force, mismatch)
            or _unmeasured_danger(max_force, unmeasured)
        )
        if reason is None and mismatch is not None:
            reason = mismatch_limit(mismatch)
        if reason is not None and self.reason is None:
            self.posture = posture.copy()
        elif self.reason is not None and touched:
            step = min(dt / YIELD_TIME, 1.0) * (posture - self.posture)
            most = dt * self.yield_speed
            self.posture = self.posture + np.clip(step, -most, most)
        if reason is not None and (self.reason is None or self._ends_when_agreed):
            self.reason = reason
        if self.reason is not None:
            waits = reason is not None or (touched and not self._ends_when_agreed)
            self._quiet = 0.0 if waits else self._quiet + dt
            if self._quiet >= (AGREED if self._ends_when_agreed else QUIET):
                self.reset()
        return self.reason is None

    def _speed_danger(self, velocity: FloatArray, point_speed: float) -> Limit | None:
        shares = np.abs(velocity) / self._stop_speed
        if largest(shares) > 1:
            fastest = int(shares.argmax())
            joint = self._joints[fastest]
            value = abs(float(velocity[fastest]))
            kind = LimitKind.STOPPED_BY_SLIDE_SPEED if joint.slide else LimitKind.STOPPED_BY_SPEED
            return Limit(kind, (joint.name,), value=value, bound=float(self._stop_speed[fastest]))
        if point_speed > STOP_POINT_SPEED:
            return Limit(LimitKind.STOPPED_BY_POINT_SPEED, value=point_speed, bound=STOP_POINT_SPEED)
        return None

    @property
    def _ends_when_agreed(self) -> bool:
        return self.reason is not None and self.reason.kind is LimitKind.STOPPED_BY_MISMATCH


def stop_speeds(joints: Sequence[Joint]) -> FloatArray:
    """Return the speed (n,) of each joint above which the arm stops [rad/s, or m/s for a slide]."""
    usual = (STOP_SLIDE_SPEED if joint.slide else STOP_SPEED for joint in joints)
    return np.array([min(most, STOP_SPEED_MARGIN * j.max_speed) for most, j in zip(usual, joints, strict=True)])


def mismatch_limit(mismatch: WrenchMismatch) -> Limit:
    """What the arm is stopped by where several contacts were read as one."""
    kind = LimitKind.STOPPED_BY_MISMATCH
    link = mismatch.link
    return Limit(kind, (link,), value=mismatch.torque, bound=mismatch.max_torque)


def _hidden_force(max_force: float, mismatch: WrenchMismatch | None) -> Limit | None:
    """Contacts that press against each other have a small resultant, however hard each of them presses."""
    if mismatch is None or mismatch.strongest <= max_force:
        return None
    return Limit(LimitKind.STOPPED_BY_FORCE, value=mismatch.strongest, bound=max_force)


def _unmeasured_danger(max_force: float, unmeasured: UnmeasuredForce) -> Limit | None:
    if unmeasured.force <= max_force:
        return None
    kind = LimitKind.STOPPED_BY_UNMEASURED_FORCE
    return Limit(kind, (unmeasured.link,), value=unmeasured.force, bound=max_force)


def is_readable(region: ContactRegion) -> bool:
    """Whether force, normal and position of a contact are finite."""
    return isfinite(region.force) and all_finite(region.link_normal) and all_finite(region.link_position)


def greatest_point_speed(configuration: Configuration, velocity: FloatArray, regions: Sequence[ContactRegion]) -> float:
    """Return the greatest speed of a touched point of the skin [m/s]; 0 where nothing touches.

    Args:
        configuration: The robot at its current posture.
        velocity: (n,).
        regions: All contacts; unreadable ones are left out.
    """
    points = [(region.link, region.link_position) for region in regions if is_readable(region)]
    return max((length(configuration.jacobian(link, at).dot(velocity)) for link, at in points), default=0.0)


def _force_danger(max_force: float, regions: Sequence[ContactRegion]) -> Limit | None:
    for region in regions:
        if not is_readable(region):
            return Limit(LimitKind.STOPPED_UNREADABLE)
        if region.force > max_force:
            return Limit(LimitKind.STOPPED_BY_FORCE, value=region.force, bound=max_force)
    return None


SHORTEST = 0.3
LONGEST = 2.0
"""For how long motion is compared [s]: an arm takes a while to follow, and slow errors are no hold."""
SHARE = 0.1
"""Share of it that must have come. Whither is not asked, if not back: on a map believed turned it comes sideways."""
AGAIN = 0.003
"""It is tried again when the error changed by so much [m]; beyond reach only when it became so much less or the target
is another, since a contact that is let go slides away by itself."""
_JUMP = 0.005


class StallDetector:
    """Compares what was asked for on the map with what came. Mutable; ``reset`` trusts again.

    A finger that tracks a place of the skin, a hand that holds it, or friction: then the arm would go on for ever. Or
    joints at their limits or stretched: then what the arm sets out to do already falls short of what is asked.

    Args:
        least: What must have been asked for before it is judged [m]; more than the taxels' pitch, since the centre of a
            contact smaller than that stays on a taxel until the next one feels it.

    Attributes:
        reason: ``CONTACT_STICKS`` where the arm moves and the contact does not slide, ``OUT_OF_REACH`` where the arm
            cannot move so; None while it comes.
    """

    def __init__(self, least: float) -> None:
        self._least = least
        self.reset()

    def reset(self) -> None:
        """Nothing known."""
        self.reason: LimitKind | None = None
        self._contact: int | None = None
        self._start_window()
        self._error: FloatArray = np.zeros(2)
        self._point: FloatArray | None = None
        self._target: SurfacePoint | None = None

    def _start_window(self) -> None:
        self._time = 0.0
        self._asked = np.zeros(2)
        self._tried = np.zeros(2)
        self._came = np.zeros(2)

    def look(
        self,
        contact: int,
        point: FloatArray,
        error: FloatArray,
        asked: FloatArray,
        tried: FloatArray,
        dt: float,
        *,
        target: SurfacePoint | None = None,
    ) -> LimitKind | None:
        """What holds the contact up; None while it comes.

        Args:
            contact: Which; a new one is trusted to slide.
            point: (2,) where it is on the map [m].
            error: (2,) how far it has to go [m].
            asked: (2,) map velocity asked for [m/s].
            tried: (2,) the one that the arm set out to make, if the contact slides [m/s].
            dt: [s].
            target: Where it has to go.
        """
        moved = self._moved(contact, point)
        if self.reason is not None and self._is_worth_another(error, target):
            self.reason = None
            self._start_window()
        if self.reason is not None:
            return self.reason
        self._time += dt
        self._asked = self._asked + asked * dt
        self._tried = self._tried + tried * dt
        if length(moved) < _JUMP:  # over a seam the place jumps
            self._came = self._came + moved
        if self._time > SHORTEST:
            self.reason = self._judged()
            self._error = error
            self._target = target
        return self.reason

    def _moved(self, contact: int, point: FloatArray) -> FloatArray:
        """How far the contact went on the map (2,) since it was last seen."""
        if contact != self._contact:
            if self.reason is not LimitKind.OUT_OF_REACH:  # that is the arm's matter, whatever touches
                self.reset()
            self._contact = contact
            self._point = None
        moved = np.zeros(2) if self._point is None else point - self._point
        self._point = point
        return moved

    def _judged(self) -> LimitKind | None:
        """What all that was asked, tried and came so far says."""
        asked = length(self._asked)
        tried = length(self._tried)
        if asked > self._least and self._tried @ self._asked < SHARE * asked**2:
            return LimitKind.OUT_OF_REACH
        enough = tried > self._least
        came = length(self._came)
        along = enough and (came < SHARE * tried or self._came @ self._tried < -SHARE * tried**2)
        if enough or self._time > LONGEST:
            self._start_window()
        return LimitKind.CONTACT_STICKS if along else None

    def _is_worth_another(self, error: FloatArray, target: SurfacePoint | None) -> bool:
        if self.reason is LimitKind.CONTACT_STICKS:
            return length(error - self._error) > AGAIN
        return target != self._target or length(error) < length(self._error) - AGAIN


FULL = 1.0
"""What a tank holds [J]: a hand followed with 3 N over 33 cm; a collision at 0.25 m/s of 5 kg is 0.16 J."""
LOW = 0.1
"""What stays in it [J]."""
RECOVERED = 0.5
"""Share of the damped power that may be used again."""


class EnergyTank:
    """Keeps count of the energy that contacts were given (Franken et al. 2011). Mutable; ``reset`` fills it.

    Attributes:
        level: What may still be given, with what stays [J].
        given: Net energy given to contacts since the reset [J]: a passivity observer; below zero the arm took.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Full, and nothing given."""
        self.level = FULL
        self.given = 0.0

    def flow(self, given: float, damped: float, dt: float) -> None:
        """Count a tick.

        Args:
            given: Power to contacts, force times outward speed [W].
            damped: Power lost in the joints' damping [W], >= 0.
            dt: [s].
        """
        self.given += given * dt
        self.level = min(max(self.level + dt * (RECOVERED * damped - given), 0.0), FULL)

    @property
    def share(self) -> float:
        """How much of a motion that gives energy is allowed: 1, and smoothly to 0 as the tank runs low."""
        part = min(max((self.level - LOW) / LOW, 0.0), 1.0)
        return part * part * (3 - 2 * part)
