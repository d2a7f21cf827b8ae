"""Monitors of controllers with a task: unsafe motion, contacts that do not follow, and energy given to contacts.

``SafetyMonitor`` stops the arm when force or speed are unsafe, and reports the reason. ``StallDetector`` detects that a
contact does not move along the map as requested. ``EnergyTank`` (Franken et al. 2011) allows the arm to give
contacts as much energy as it received from them and from its damping.
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
"""A joint stops the arm at this multiple of its model's largest speed, if that is less."""
STOP_POINT_SPEED = 1.0
"""Largest speed of a contact point [m/s]; four times the largest that controllers request."""
YIELD_TIME = 0.5
"""Time constant with which a stopped arm yields to a remaining contact [s]."""
YIELD_SPEED = 0.6
YIELD_SLIDE_SPEED = 0.1
"""Largest speed at which a stopped arm yields, of a hinge [rad/s] and of a slide [m/s]; faster motion is damped."""
UNMEASURED_TOUCH = 3.0
"""Force that the skin does not measure [N] above which a stopped arm is still touched."""
QUIET = 1.0
"""Time without contact after which the controller continues [s]."""
AGREED = 0.2
"""Time for which one contact must explain the wrench before the controller continues [s]."""


class SafetyMonitor:
    """Stops the arm and lets the controller continue. Mutable; ``reset`` lets it continue.

    It continues by itself after ``QUIET`` without contact; if several contacts were read as one wrench, after a single
    one has explained it for ``AGREED``.

    Args:
        joints: The robot's joints, in the order of a posture.

    Attributes:
        reason: Reason of the stop; None while the controller continues.
        posture: (n,) posture to hold: that of the stop, moved with the arm while something touches it, at most at
            ``yield_speed``.
        yield_speed: (n,) largest speed at which a stopped arm yields [rad/s, or m/s for a slide].
    """

    def __init__(self, joints: Sequence[Joint]) -> None:
        self._joints = tuple(joints)
        self._stop_speed = stop_speeds(joints)
        usual = (YIELD_SLIDE_SPEED if joint.slide else YIELD_SPEED for joint in joints)
        self.yield_speed = np.array([min(most, joint.max_speed) for most, joint in zip(usual, joints, strict=True)])
        self.reset()

    def reset(self) -> None:
        """Let the controller continue."""
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
    """Return the limit for several contacts that were read as one."""
    kind = LimitKind.STOPPED_BY_MISMATCH
    link = mismatch.link
    return Limit(kind, (link,), value=mismatch.torque, bound=mismatch.max_torque)


def _hidden_force(max_force: float, mismatch: WrenchMismatch | None) -> Limit | None:
    """Return a stop for contacts that press against each other: their resultant may be small."""
    if mismatch is None or mismatch.strongest <= max_force:
        return None
    return Limit(LimitKind.STOPPED_BY_FORCE, value=mismatch.strongest, bound=max_force)


def _unmeasured_danger(max_force: float, unmeasured: UnmeasuredForce) -> Limit | None:
    if unmeasured.force <= max_force:
        return None
    kind = LimitKind.STOPPED_BY_UNMEASURED_FORCE
    return Limit(kind, (unmeasured.link,), value=unmeasured.force, bound=max_force)


def is_readable(region: ContactRegion) -> bool:
    """Whether force, normal and position of a contact are finite, and its shear if it is measured."""
    shear = () if region.shear is None else (*region.shear.force, region.shear.friction)
    along = all(isfinite(number) for number in (region.force, *shear))
    return along and all_finite(region.link_normal) and all_finite(region.link_position)


def greatest_point_speed(configuration: Configuration, velocity: FloatArray, regions: Sequence[ContactRegion]) -> float:
    """Return the largest speed of a contact point [m/s]; 0 without contacts.

    Args:
        configuration: The robot at its current posture.
        velocity: (n,) joint velocity.
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
"""Smallest and largest time over which motion is compared [s]: an arm follows with a lag."""
SHARE = 0.1
"""Share of the requested motion that must occur. Its direction does not count unless it is backwards: with a rotated
map the contact moves sideways."""
AGAIN = 0.003
"""Change of the error [m] after which the contact is tried again. If the arm hardly moved it, it is tried again only
where the error has decreased by this much or the target is another one, since a released contact slides by itself."""
_JUMP = 0.005


class StallDetector:
    """Compares requested with actual motion on the map. Mutable; ``reset`` discards its result.

    A finger that tracks a place of the skin, a hand that holds it, or friction would let the arm move on without end.
    If joints are at their limits or stretched, the motion that the arm attempts already falls short of the request.
    The detector states the motions and no cause; ``TargetReach`` finds whether the target is out of reach.

    Args:
        least: Requested motion before the contact is judged [m]; more than the taxels' pitch, since the centre of a
            smaller contact stays on a taxel until the next one detects it.

    Attributes:
        reason: ``CONTACT_STICKS`` if the arm moves the skin and the place of the contact on it does not change,
            ``NO_APPROACH`` if the arm attempts less than ``SHARE`` of the motion; None while the contact moves.
    """

    def __init__(self, least: float) -> None:
        self._least = least
        self.reset()

    def reset(self) -> None:
        """Discard the past."""
        self.reason: Limit | None = None
        self._contact: int | None = None
        self._start_window()
        self._error: FloatArray = np.zeros(2)
        self._point: FloatArray | None = None
        self._target: SurfacePoint | None = None

    def _start_window(self) -> None:
        self._time = 0.0
        self._requested = np.zeros(2)
        self._tried = np.zeros(2)
        self._came = np.zeros(2)

    def look(
        self,
        contact: int,
        point: FloatArray,
        error: FloatArray,
        requested: FloatArray,
        tried: FloatArray,
        dt: float,
        *,
        target: SurfacePoint | None = None,
        yielding: float = 0.0,
    ) -> Limit | None:
        """Return the limit of a contact that does not move; None while it moves.

        Args:
            contact: Id of the contact; a new one is expected to slide.
            point: (2,) its place on the map [m].
            error: (2,) vector to the target [m].
            requested: (2,) requested map velocity [m/s].
            tried: (2,) map velocity that the arm attempts, if the contact slides [m/s].
            dt: Time step [s].
            target: The target.
            yielding: Largest way that the arm attempts and its soft joints absorb [m].
        """
        moved = self._moved(contact, point)
        if self.reason is not None and self._is_worth_another(error, target):
            self.reason = None
            self._start_window()
        if self.reason is not None:
            return self.reason
        self._time += dt
        self._requested = self._requested + requested * dt
        self._tried = self._tried + tried * dt
        if length(moved) < _JUMP:  # the place on the map jumps at a seam
            self._came = self._came + moved
        if self._time > SHORTEST:
            self.reason = self._judged(self._least + yielding)
            self._error = error
            self._target = target
        return self.reason

    def _moved(self, contact: int, point: FloatArray) -> FloatArray:
        """Return the motion of the contact on the map (2,) since the last tick."""
        if contact != self._contact:
            if self._kind is not LimitKind.NO_APPROACH:  # depends on the arm, not on the contact
                self.reset()
            self._contact = contact
            self._point = None
        moved = np.zeros(2) if self._point is None else point - self._point
        self._point = point
        return moved

    @property
    def _kind(self) -> LimitKind | None:
        return None if self.reason is None else self.reason.kind

    def _judged(self, least: float) -> Limit | None:
        """Return the result for the requested, attempted and actual motion, once it is above ``least`` [m]."""
        requested = length(self._requested)
        tried = length(self._tried)
        if requested > least and self._tried @ self._requested < SHARE * requested**2:
            made = max(float(self._tried @ self._requested) / requested, 0.0)
            return Limit(LimitKind.NO_APPROACH, value=made, bound=requested)
        enough = tried > least
        came = length(self._came)
        along = enough and (came < SHARE * tried or self._came @ self._tried < -SHARE * tried**2)
        if enough or self._time > LONGEST:
            self._start_window()
        return Limit(LimitKind.CONTACT_STICKS) if along else None

    def _is_worth_another(self, error: FloatArray, target: SurfacePoint | None) -> bool:
        if self._kind is LimitKind.CONTACT_STICKS:
            return length(error - self._error) > AGAIN
        return target != self._target or length(error) < length(self._error) - AGAIN


FULL = 1.0
"""Capacity of a tank [J]: a hand followed with 3 N over 33 cm; a collision of 5 kg at 0.25 m/s has 0.16 J."""
LOW = 0.1
"""Energy that remains in the tank [J]."""
RECOVERED = 0.5
"""Share of the damped power that may be used again."""


class EnergyTank:
    """Counts the energy given to contacts (Franken et al. 2011). Mutable; ``reset`` fills it.

    Attributes:
        level: Energy that may still be given, including ``LOW`` [J].
        given: Net energy given to contacts since the reset [J] (passivity observer); negative if the arm received
            energy.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Fill the tank and count from zero."""
        self.level = FULL
        self.given = 0.0

    def flow(self, given: float, damped: float, dt: float) -> None:
        """Count one tick.

        Args:
            given: Power to contacts, force times speed of the touching bodies, along the normal and, where the skin
                measures shear, along the skin [W].
            damped: Power lost in the joints' damping [W], >= 0.
            dt: Time step [s].
        """
        self.given += given * dt
        self.level = min(max(self.level + dt * (RECOVERED * damped - given), 0.0), FULL)

    @property
    def share(self) -> float:
        """Allowed share of a motion that gives energy: 1, and smoothly to 0 as the tank becomes empty."""
        part = min(max((self.level - LOW) / LOW, 0.0), 1.0)
        return part * part * (3 - 2 * part)
