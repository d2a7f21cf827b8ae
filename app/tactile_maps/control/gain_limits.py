"""Gains held to what the skin's times, the arm and what it presses on allow, or told to be more."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.controller_registry import TASKS_AT_A_PLACE
from tactile_maps.control.controllers import ALL_CONTACTS
from tactile_maps.control.force_loop.contact_stiffness import StiffnessEstimator
from tactile_maps.control.force_loop.loop_stability import CONTACT_STIFFNESS, GONE, OscillationDetector, SensorTiming
from tactile_maps.control.force_loop.pressed_arm import LoopFilter, pressed_arm
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import INNER_FREQUENCY, JointImpedance
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.control.task_control.contact_selection import ContactSelection
from tactile_maps.core.arrays import FloatArray, largest
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot

GAIN_SHARE = 0.35
"""Of the limit of stability at a measured contact, that limited gains take: a gain margin of 2.9. With joints that
follow at once it leaves 60 degrees of phase and overshoots by at most 7 % however late the skin is (z**(d + 1) - z**d +
g = 0; at 0.5 it is 25 % from one sample on)."""
NOMINAL_SHARE = 0.9
SAMPLED_SHARE = 0.3
"""While the contact counts as nominal: of the limit there, and no more than this of the limit were joints to follow at
once. The reserve of the first is in the stiffness, four times that of a cover; one that is really so stiff swings, is
measured by that, and gets ``GAIN_SHARE``. With a slow skin that takes seconds, so there the second holds from the
start."""
INERTIA_SHARE = 0.9
"""Of the limit at a measured contact, that limited gains with a virtual inertia take at most."""
SOFT_RATE = 4.0
"""Rate at which the force approaches its goal [1/s], below which a limited gain is raised where joints are soft."""
_DAMPED = 2.0
"""Four times the square of the least damping ratio that an integral leaves."""
CALM = 10.0
"""Time [s] without oscillation after which a halved gain is doubled again. It is doubled with each oscillation."""
LEAST_SHARE = 1 / 32
"""Smallest share of the limited gain that halving leaves. A loop that oscillates with it is reported."""
STUCK_SHARE = 0.3
"""Share of the commanded motion that a touched point makes at least; its integral does not grow while it makes less."""
_SMOOTHED = 0.15
"""Time constant [s] with which commanded and measured motion are compared: joints follow with 0.05 s."""
_STANDS = 1e-5
"""Commanded speed [m/s] below which nothing is expected to move."""
PLACE_SHARE = 0.3
"""Of one over what passes from a touch to its reading, that the gain of place takes."""
_PATIENCE = 12.0
"""An integral is no faster than so many times what passes from a touch to its reading: it follows the answer."""
_OF_THE_PATH = ("path_kind", "path", "path_size", "path_speed", "starts")
_SAME = 1.03
_MOVED = 0.05
"""By how much stiffness [as a factor] or a joint [rad, m] have to change for the limit to be worked out anew."""


@dataclass(frozen=True, eq=False)
class _LoopLimit:
    """Limit of the force gain at one contact, and for what it was computed.

    Attributes:
        stiffness: Of the contact [N/m].
        measured: Whether the stiffness is measured.
        posture: (n,) of the arm.
        series: Stiffness of the contact and the joints in series [N/m].
        most: Force gain from which on the force oscillates [m/s/N].
        held: Force gain that limited settings take [m/s/N].
    """

    stiffness: float
    measured: bool
    posture: FloatArray
    series: float
    most: float
    held: float

    def holds(self, stiffness: float, posture: FloatArray, *, measured: bool) -> bool:
        """Return whether the limit holds for a contact about as stiff, with the arm about there."""
        same = measured == self.measured and self.stiffness / _SAME < stiffness < self.stiffness * _SAME
        return same and largest(posture - self.posture) < _MOVED


class _FollowedContact:
    """What is measured of one contact. Mutable.

    Attributes:
        link: Name of the touched link.
        estimator: Of its stiffness.
        detector: Of oscillations of its force.
        outward: (n,) outward speed of the touched point per joint velocity, when it was last felt.
        ways: Outward way of the touched point since it was first felt [m], as old as a reading and newer.
        asked: Outward speed of the touched point that the commanded posture gives, smoothed over ``_SMOOTHED`` [m/s].
        moved: Measured outward speed of the touched point, smoothed alike [m/s].
        missing: Time since it was last felt [s]; inf before its way begins.
        limit: Computed last; None before.
    """

    def __init__(self, link: str, outward: FloatArray) -> None:
        self.link = link
        self.estimator = StiffnessEstimator(CONTACT_STIFFNESS)
        self.detector = OscillationDetector()
        self.outward = outward
        self.ways = deque([0.0])
        self.asked = self.moved = 0.0
        self.missing = math.inf
        self.limit: _LoopLimit | None = None

    def move(self, moved: float, asked: float, dt: float) -> None:
        """Take the outward way (measured and commanded) of the touched point in a tick [m]."""
        self.ways.append(self.ways[-1] + moved)
        share = min(dt / _SMOOTHED, 1.0)
        self.moved += share * (moved / dt - self.moved)
        self.asked += share * (asked / dt - self.asked)

    @property
    def stuck(self) -> bool:
        """True if the touched point does not make the commanded motion, less what soft joints give way."""
        if self.limit is None or abs(self.asked) < _STANDS:
            return False
        expected = self.asked * self.limit.series / self.limit.stiffness
        return self.moved * expected < STUCK_SHARE * expected**2


@dataclass(frozen=True, eq=False)
class _Answer:
    """Gains computed last, and for what."""

    contacts: tuple[int, ...]
    settings: ControlSettings
    readings: SensorTiming
    most: float
    taken: ControlSettings
    limits: tuple[Limit, ...]

    def for_another_path(self, settings: ControlSettings) -> _Answer:
        """The same answer with what else ``settings`` say; the two are of the same loop."""
        taken = self.taken
        gains = {name: getattr(taken, name) for name in ("force_gain", "position_gain", "integral_time")}
        return replace(self, settings=settings, taken=replace(settings, **gains))


class GainLimiter:
    """Compares gains with the most that the loop of skin, arm and contacts can hold. Mutable.

    Where settings are ``limited``, the force gain is held to a share of that limit, the integral is no faster than
    the response to it, and the position gain is ``PLACE_SHARE`` of the inverse of the delay from a touch to its
    reading. The contact stiffness comes from the arm's own approach (``contact_stiffness``); until it has been measured
    it is nominal, and the shares are ``NOMINAL_SHARE`` and ``SAMPLED_SHARE``.

    Where a robot touches itself nothing is measured: one side's way is not what brings them together. Controllers with
    a virtual inertia (admittance, parallel) keep to ``SAMPLED_SHARE`` of the nominal limit of joints that follow at
    once, and to ``INERTIA_SHARE`` of the limit at a measured contact.

    Where joints are so soft against a measured contact that the force would approach its goal with less than
    ``SOFT_RATE``, the gain is raised, at most until the touched point moves as fast as the gain asks.

    Each contact that is controlled is measured and has its own limit. The controller has one force gain for all, which
    is the smallest.

    Args:
        robot: Whose joints hold the arm against the contact.

    Attributes:
        readings: Of the skin; None says nothing.
        most: The force gain from which on the force of a contact would swing, as worked out last [m/s/N]; None until
            then.
        oscillates: Whether the force of a controlled contact oscillates.
        reduced: Whether the force gain is reduced because the force has oscillated.
        exhausted: Whether the force has oscillated with the smallest gain.
        stuck: Ids of contacts whose point does not make the commanded motion: friction, or something else, holds it.

    Cost: 20 µs a tick for each contact, 0.3 ms when another contact or other settings come, or the contact shows to be
    stiffer or softer, or the arm has moved on.
    """

    def __init__(self, robot: Robot) -> None:
        self._configuration = Configuration(robot)
        self._impedance = JointImpedance(self._configuration, frequency=INNER_FREQUENCY, damping_ratio=1.0)
        self._selection = ContactSelection()
        self.readings: SensorTiming | None = None
        self.reset()

    def reset(self) -> None:
        """Nothing has touched."""
        self._answer: _Answer | None = None
        self._first: int | None = None
        self._contacts: dict[int, _FollowedContact] = {}
        self._before: tuple[FloatArray, FloatArray] | None = None
        self._selection.reset()
        self._set_full()

    def _set_full(self) -> None:
        """Take the whole gain again."""
        self.oscillates = self.exhausted = False
        self._share = 1.0
        self._patience = 0.5 * CALM
        self._calm = 0.0
        self._oscillated: ControlSettings | None = None
        self._reduced: tuple[ControlSettings, float, ControlSettings] | None = None

    @property
    def stuck(self) -> frozenset[int]:
        """See above."""
        return frozenset(id_ for id_, contact in self._contacts.items() if contact.stuck)

    def halve(self, settings: ControlSettings) -> None:
        """Halve the limited force gain, since the force oscillates under ``settings``. It recovers while it is calm."""
        self._oscillated = settings
        self._calm = 0.0
        self.exhausted = self._share <= LEAST_SHARE
        if not self.exhausted:
            self._share *= 0.5
            self._patience *= 2

    @property
    def reduced(self) -> bool:
        """See above."""
        return self._share < 1.0

    @property
    def most(self) -> float | None:
        """See above."""
        return None if self._answer is None else self._answer.most

    def effective_settings(
        self,
        settings: ControlSettings,
        posture: FloatArray,
        regions: Sequence[ContactRegion],
        dt: float,
        *,
        commanded: FloatArray | None = None,
    ) -> tuple[ControlSettings, tuple[Limit, ...]]:
        """The settings as a controller may take them, and the limits that this is while something touches.

        Args:
            settings: As they are set. What was made of them stays while nothing touches, since what was lost is sought
                at their speed.
            posture: (n,) found.
            regions: All contacts, the strongest first.
            dt: Since the last tick [s].
            commanded: (n,) the posture commanded at the last tick; None for none yet.
        """
        if settings.controller == "impedance":
            return settings, ()
        if self._oscillated is not None and not _of_the_same_loop(self._oscillated, settings):
            self._set_full()
        controlled = self._controlled(settings, regions)
        self._measure(posture, regions, controlled, dt, commanded)
        self._watch(settings, regions, dt)
        known = self._answer_for(settings, posture, controlled, dt)
        if known is None:
            return self._calmed(settings, dt), ()
        return self._calmed(known.taken, dt), known.limits if regions else ()

    def _controlled(self, settings: ControlSettings, regions: Sequence[ContactRegion]) -> list[ContactRegion]:
        """Return the contacts that have a force goal: the one known from before, and all others above the goal."""
        if not regions:
            return []
        first = next((one for one in regions if one.id == self._first), regions[0])
        self._first = first.id
        if settings.controller != "hold_force" and settings.task in ALL_CONTACTS:
            return [first, *(one for one in regions if one.id != first.id)]
        return [first, *self._selection.others(first, regions, settings.force_goal)]

    def _calmed(self, settings: ControlSettings, dt: float) -> ControlSettings:
        """Return the settings with a gain that is reduced because the force has oscillated; it recovers with time."""
        if self._share == 1.0 or settings.gains != "limited":
            return settings
        self._calm += dt
        if self._calm > self._patience:
            self._share = 2 * self._share
            self._calm = 0.0
            self.exhausted = False
        known = self._reduced
        if known is None or known[0] is not settings or known[1] != self._share:
            reduced = replace(settings, force_gain=self._share * settings.force_gain)
            known = self._reduced = (settings, self._share, reduced)
        return known[2]

    def _known(self, settings: ControlSettings, readings: SensorTiming) -> _Answer | None:
        known = self._answer
        if known is None or known.readings != readings or not _of_the_same_loop(known.settings, settings):
            return None
        if known.settings is not settings:
            self._answer = known = known.for_another_path(settings)
        return known

    def _measure(
        self,
        posture: FloatArray,
        regions: Sequence[ContactRegion],
        controlled: Sequence[ContactRegion],
        dt: float,
        commanded: FloatArray | None,
    ) -> None:
        """Take the motion of the last tick; the configuration is at ``posture`` afterwards where something touches."""
        commanded = posture if commanded is None else commanded
        before = self._before
        self._before = (posture, commanded)
        felt = {one.id: one for one in regions if one.id in self._contacts} | {one.id: one for one in controlled}
        if felt:
            self._configuration.update(posture)
            lost = [id_ for id_, contact in self._contacts.items() if id_ not in felt and contact.missing > GONE]
            for id_ in lost:
                del self._contacts[id_]
        delay = 0.0 if self.readings is None else self.readings.delay
        for id_ in felt.keys() - self._contacts.keys():
            self._contacts[id_] = self._begun(felt[id_], felt.keys())
        for id_, contact in self._contacts.items():
            region = felt.get(id_)
            begins = contact.missing == math.inf or before is None
            if region is not None and not begins:
                contact.outward = self._outward(region)
            way = asked = 0.0
            if not begins:
                assert before is not None
                way, asked = (
                    float(contact.outward.dot(now - then))
                    for now, then in zip((posture, commanded), before, strict=True)
                )
            contact.move(way, asked, dt)
            while len(contact.ways) > round(delay / dt) + 1:
                contact.ways.popleft()
            contact.missing = contact.missing + dt if region is None else 0.0
            if region is not None and not begins and region.partner is None and self.readings is not None:
                contact.estimator.look(region.force, way, asked, dt, delay)

    def _begun(self, region: ContactRegion, felt: Collection[int]) -> _FollowedContact:
        """Return a new contact; one that bounces comes back as a new one, and keeps its swings."""
        same = (id_ for id_, one in self._contacts.items() if id_ not in felt and one.link == region.link)
        bounced = next(same, None)
        if bounced is None:
            return _FollowedContact(region.link, self._outward(region))
        contact = self._contacts.pop(bounced)
        contact.outward = self._outward(region)
        contact.limit = None
        contact.estimator.reset()
        return contact

    def _outward(self, region: ContactRegion) -> FloatArray:
        """Return the outward speed of the touched point per joint velocity (n,)."""
        normal = self._configuration.pose(region.link).rotation.dot(region.link_normal)
        return normal.dot(self._configuration.jacobian(region.link, region.link_position))

    def _watch(self, settings: ControlSettings, regions: Sequence[ContactRegion], dt: float) -> None:
        """Notice oscillations, and halve the gain where it is limited."""
        forces = {region.id: region.force for region in regions}
        swings = [
            contact.detector.look(settings.force_goal, forces.get(id_, 0.0), contact.ways[0], dt)
            for id_, contact in self._contacts.items()
        ]
        self.oscillates = any(swings)
        if self.oscillates and settings.gains == "limited":
            self.halve(settings)
            for contact in self._contacts.values():
                contact.detector.reset()

    def _answer_for(
        self, settings: ControlSettings, posture: FloatArray, controlled: Sequence[ContactRegion], dt: float
    ) -> _Answer | None:
        if self.readings is None:
            return None
        known = self._known(settings, self.readings)
        if known is None:
            for contact in self._contacts.values():
                contact.limit = None
        limits = list[_LoopLimit]()
        changed = False
        for region in controlled:
            contact = self._contacts[region.id]
            stiffness = contact.estimator.stiffness(max(settings.force_goal, region.force))
            limit = contact.limit
            measured = contact.estimator.measured
            if limit is None or not limit.holds(stiffness, posture, measured=measured):
                held = self._loop_limit(settings, posture, region, dt, self.readings, stiffness, measured=measured)
                limit = contact.limit = held
                changed = True
            limits.append(limit)
        ids = tuple(region.id for region in controlled)
        if limits and (changed or known is None or known.contacts != ids):
            known = self._answer = _smallest(ids, settings, self.readings, limits)
        return known

    def _loop_limit(
        self,
        settings: ControlSettings,
        posture: FloatArray,
        region: ContactRegion,
        dt: float,
        readings: SensorTiming,
        stiffness: float,
        *,
        measured: bool,
    ) -> _LoopLimit:
        calm = _limited(settings, readings)
        loop = LoopFilter.of(settings)
        at_a_place = settings.controller != "hold_force" and settings.task in TASKS_AT_A_PLACE
        slides = not at_a_place or region.id != self._first
        arm = pressed_arm(self._configuration, self._impedance, region, stiffness, slides=slides)
        most = arm.gain_limit(LoopFilter.of(calm), readings, dt)
        if loop.inertia_time > 0:
            # A lower gain lets the place, or a wrong normal, win over the force before the loop swings.
            held = SAMPLED_SHARE * replace(arm, stiffness=CONTACT_STIFFNESS).sampled_limit(readings)
            if measured:
                held = min(held, INERTIA_SHARE * most)
        else:
            sampled = SAMPLED_SHARE * arm.sampled_limit(readings)
            held = GAIN_SHARE * most if measured else min(NOMINAL_SHARE * most, sampled)
        series = arm.series_stiffness
        gain = settings.force_gain
        if measured and series > 0:  # soft joints give way: the point moves by less than the posture does
            gain = max(gain, min(SOFT_RATE, gain * stiffness) / series)
        return _LoopLimit(stiffness, measured, posture, series, most, min(gain, held))


def _smallest(
    contacts: tuple[int, ...], settings: ControlSettings, readings: SensorTiming, limits: Sequence[_LoopLimit]
) -> _Answer:
    """Return the gains that the loops of all contacts can hold."""
    most = min(limit.most for limit in limits)
    if settings.gains != "limited":
        return _Answer(contacts, settings, readings, most, settings, _unstable(settings, most, readings))
    calm = _limited(settings, readings)
    gain = min(limit.held for limit in limits)
    drawn = LoopFilter.of(calm).position_gain
    integral = max([calm.integral_time, *(_damped_integral(gain, drawn, limit) for limit in limits if limit.measured)])
    calm = replace(calm, force_gain=gain, integral_time=integral)
    return _Answer(contacts, settings, readings, most, calm, _held_back(settings, calm, readings))


def _damped_integral(gain: float, drawn: float, limit: _LoopLimit) -> float:
    """Return the least integral time [s] for a damping ratio of 0.7 of  s^2 + (rate + back) s + rate / time.

    The rate at which the force approaches its goal without integral is gain times series stiffness, and the point is
    drawn back at a rate ``drawn`` [1/s], less what soft joints give way.
    """
    rate = gain * limit.series
    back = drawn * limit.series / limit.stiffness
    return _DAMPED * rate / (rate + back) ** 2 if rate > 0 else 0.0


def _of_the_same_loop(one: ControlSettings | None, other: ControlSettings) -> bool:
    """Whether only the path differs, which a target that is drawn or learned changes many times a second: how much gain
    the loop can hold does not depend on it.
    """
    if one is None or one is other:
        return one is other
    path = {name: getattr(other, name) for name in _OF_THE_PATH}
    return replace(one, **path) == other


def _limited(settings: ControlSettings, readings: SensorTiming) -> ControlSettings:
    """Integral and place as slow as the readings ask for, where gains are limited."""
    if settings.gains == "as_given":
        return settings
    wait = readings.period + readings.delay
    place = min(settings.position_gain, PLACE_SHARE / wait)
    integral = max(settings.integral_time, _PATIENCE * wait)
    return replace(settings, position_gain=place, integral_time=integral)


def _unstable(settings: ControlSettings, most: float, readings: SensorTiming) -> tuple[Limit, ...]:
    """That a gain that stays as it is set is more than the loop can hold, if it is."""
    if settings.force_gain <= most:
        return ()
    kind = LimitKind.FORCE_GAIN_UNSTABLE
    period = readings.period
    delay = readings.delay
    return (Limit(kind, value=settings.force_gain, bound=most, period=period, delay=delay),)


def _held_back(settings: ControlSettings, calm: ControlSettings, readings: SensorTiming) -> tuple[Limit, ...]:
    held = [
        (LimitKind.FORCE_GAIN_HELD, calm.force_gain, settings.force_gain),
        (LimitKind.POSITION_GAIN_HELD, calm.position_gain, settings.position_gain),
    ]
    limits = tuple(
        Limit(kind, value=value, bound=asked, period=readings.period, delay=readings.delay)
        for kind, value, asked in held
        if value < asked
    )
    if calm.force_gain > settings.force_gain:
        return (*limits, Limit(LimitKind.FORCE_GAIN_RAISED, value=calm.force_gain, bound=settings.force_gain))
    return limits
