"""Force, position and integral gains reduced, or raised, to what skin timing, arm and contact allow."""

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
from tactile_maps.control.motion.joint_impedance import posture_loop
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.control.task_control.contact_selection import ContactSelection
from tactile_maps.core.arrays import FloatArray, largest
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot

GAIN_SHARE = 0.35
"""Share of the stability limit at a measured contact that a limited force gain may use: a gain margin of 2.9. With
ideal joints it leaves a phase margin of 60 degrees and at most 7 % overshoot for any delay of the skin (roots of
z**(d + 1) - z**d + g = 0; with a share of 0.5 it is 25 % from one sample of delay on)."""
NOMINAL_SHARE = 0.9
SAMPLED_SHARE = 0.3
"""Shares while the contact has nominal stiffness: of the stability limit there, and of the limit for ideal joints. The
nominal stiffness, four times that of a cover, holds the reserve of the first. A contact that really is so stiff makes
the force oscillate, is measured by that, and gets ``GAIN_SHARE``. A slow skin needs seconds for this, so the second
share bounds the gain from the start."""
INERTIA_SHARE = 0.9
"""Largest share of the stability limit at a measured contact for limited gains with a virtual inertia."""
SOFT_RATE = 4.0
"""Rate [1/s] at which the force approaches its goal, below which a limited gain is raised for soft joints."""
_DAMPED = 2.0
"""Four times the square of the smallest damping ratio that an integral leaves."""
CALM = 10.0
"""Time [s] without oscillation after which a halved gain is doubled again; each oscillation doubles this time."""
ENDED = 2.0
"""Time [s] without a swing after which an oscillation is no longer reported. Swings of a reported one are at most 1 s
apart on average, and it takes five more to report it again."""
LEAST_SHARE = 1 / 32
"""Smallest share of the limited gain that halving leaves. A loop that oscillates with it is reported."""
STUCK_SHARE = 0.3
"""Share of the commanded motion that a contact point must make; its integral does not grow while it makes less."""
_SMOOTHED = 0.15
"""Time constant [s] with which commanded and measured motion are compared: joints follow with 0.05 s."""
_STILL = 1e-5
"""Commanded speed [m/s] below which no motion is expected."""
PLACE_SHARE = 0.3
"""Largest position gain, as a share of the inverse of the time from a touch to its reading."""
_PATIENCE = 12.0
"""Smallest integral time in multiples of the time from a touch to its reading."""
_OF_THE_PATH = ("path_kind", "path", "path_size", "path_speed", "starts")
_SAME = 1.03
_MOVED = 0.05
"""Relative change of stiffness, and change of a joint [rad or m], for which the limit is computed again."""


@dataclass(frozen=True, eq=False)
class _LoopLimit:
    """Force gain limit of one contact and the conditions it was computed for.

    Attributes:
        stiffness: Contact stiffness [N/m].
        measured: Whether the stiffness is measured.
        posture: (n,) posture of the arm.
        series: Stiffness of the contact and the joints in series [N/m].
        settling: The smallest value of it that the integral allows for [N/m]: friction may hold the contact point.
        most: Force gain above which the force oscillates [m/s/N].
        held: Force gain that limited settings use [m/s/N].
    """

    stiffness: float
    measured: bool
    posture: FloatArray
    series: float
    settling: float
    most: float
    held: float

    def holds(self, stiffness: float, posture: FloatArray, *, measured: bool) -> bool:
        """Return whether the limit is valid for this contact stiffness and posture."""
        same = measured == self.measured and self.stiffness / _SAME < stiffness < self.stiffness * _SAME
        return same and largest(posture - self.posture) < _MOVED


class _FollowedContact:
    """Measurements of one contact. Mutable.

    Attributes:
        link: Name of the touched link.
        estimator: Estimates the contact stiffness.
        detector: Detects oscillations of its force.
        outward: (n,) outward speed of the contact point per joint velocity, at the last reading of the contact.
        ways: Outward displacement of the contact point since the first touch [m], from the age of a reading to now.
        commanded: Outward speed of the contact point by the commanded posture, smoothed over ``_SMOOTHED`` [m/s].
        moved: Measured outward speed of the contact point, smoothed in the same way [m/s].
        missing: Time since the contact was last read [s]; inf before its displacement is recorded.
        limit: Limit computed last; None before.
    """

    def __init__(self, link: str, outward: FloatArray) -> None:
        self.link = link
        self.estimator = StiffnessEstimator(CONTACT_STIFFNESS)
        self.detector = OscillationDetector()
        self.outward = outward
        self.ways = deque([0.0])
        self.commanded = self.moved = 0.0
        self.missing = math.inf
        self.limit: _LoopLimit | None = None

    def move(self, moved: float, commanded_way: float, dt: float) -> None:
        """Add the measured and the commanded outward displacement of the contact point in one tick [m]."""
        self.ways.append(self.ways[-1] + moved)
        share = min(dt / _SMOOTHED, 1.0)
        self.moved += share * (moved / dt - self.moved)
        self.commanded += share * (commanded_way / dt - self.commanded)

    @property
    def stuck(self) -> bool:
        """True if the contact point does not follow the commanded motion, less the deflection of soft joints."""
        if self.limit is None or abs(self.commanded) < _STILL:
            return False
        expected = self.commanded * self.limit.series / self.limit.stiffness
        return self.moved * expected < STUCK_SHARE * expected**2


@dataclass(frozen=True, eq=False)
class _EffectiveGains:
    """Gains computed last and the conditions they were computed for."""

    contacts: tuple[int, ...]
    settings: ControlSettings
    readings: SensorTiming
    most: float
    taken: ControlSettings
    limits: tuple[Limit, ...]

    def for_another_path(self, settings: ControlSettings) -> _EffectiveGains:
        """Return the same gains for ``settings`` of the same loop with another path."""
        taken = self.taken
        gains = {name: getattr(taken, name) for name in ("force_gain", "position_gain", "integral_time")}
        return replace(self, settings=settings, taken=replace(settings, **gains))


class GainLimiter:
    """Compares gains with the stability limit of the loop of skin, arm and contacts. Mutable.

    With ``gains="limited"``, the force gain uses a share of that limit, the integral is no faster than the response to
    it, and the position gain is at most ``PLACE_SHARE`` of the inverse of the delay from a touch to its reading. The
    contact stiffness comes from the arm's own approach (``contact_stiffness``); until it has been measured it is
    nominal, and the shares are ``NOMINAL_SHARE`` and ``SAMPLED_SHARE``.

    Self-contacts are not measured: the motion of one side alone does not give the approach of both. Controllers with a
    virtual inertia (admittance, parallel) use at most ``SAMPLED_SHARE`` of the nominal limit for ideal joints and
    ``INERTIA_SHARE`` of the limit at a measured contact.

    If joints are so soft against a measured contact that the force would approach its goal at less than ``SOFT_RATE``,
    the gain is raised, at most until the contact point moves as fast as the gain requests.

    Each controlled contact is measured and has its own limit. The controller uses the smallest of their force gains for
    all.

    Args:
        robot: Robot whose joints hold the arm against the contact.

    Attributes:
        readings: Timing of the skin's readings; None disables the limits.
        oscillates: Whether the force of a contact oscillates, or did within the last ``ENDED`` seconds.
        exhausted: Whether the force has oscillated at the smallest gain, which has not been raised since.

    Cost: 20 µs a tick for each contact; 0.3 ms when contacts, settings, measured stiffness or posture have changed.
    """

    def __init__(self, robot: Robot) -> None:
        self._configuration = Configuration(robot)
        self._impedance = posture_loop(self._configuration)
        self._selection = ContactSelection()
        self.readings: SensorTiming | None = None
        self.reset()

    def reset(self) -> None:
        """Discard all contacts."""
        self._current: _EffectiveGains | None = None
        self._first: int | None = None
        self._contacts: dict[int, _FollowedContact] = {}
        self._before: tuple[FloatArray, FloatArray] | None = None
        self._selection.reset()
        self._set_full()

    def _set_full(self) -> None:
        """Remove the reduction of the force gain."""
        self.oscillates = self.exhausted = False
        self._share = 1.0
        self._patience = 0.5 * CALM
        self._calm = 0.0
        self._oscillated: ControlSettings | None = None
        self._reduced: tuple[ControlSettings, float, ControlSettings] | None = None

    @property
    def stuck(self) -> frozenset[int]:
        """Ids of contacts whose point does not follow the commanded motion, because of friction or another obstacle."""
        return frozenset(id_ for id_, contact in self._contacts.items() if contact.stuck)

    def halve(self, settings: ControlSettings) -> None:
        """Halve the limited force gain, because the force oscillates; it recovers while the force is calm."""
        self._oscillated = settings
        self._calm = 0.0
        self.exhausted = self._share <= LEAST_SHARE
        if not self.exhausted:
            self._share *= 0.5
            self._patience *= 2

    @property
    def reduced(self) -> bool:
        """Whether the force gain is reduced because the force has oscillated."""
        return self._share < 1.0

    @property
    def most(self) -> float | None:
        """Smallest force gain above which the force of a contact oscillates [m/s/N]; None before the first contact."""
        return None if self._current is None else self._current.most

    def effective_settings(
        self,
        settings: ControlSettings,
        posture: FloatArray,
        regions: Sequence[ContactRegion],
        dt: float,
        *,
        commanded: FloatArray | None = None,
    ) -> tuple[ControlSettings, tuple[Limit, ...]]:
        """Return the settings that a controller may use and the limits to report while something touches.

        Args:
            settings: Settings of the user. The gains stay unchanged while nothing touches, because a lost contact is
                searched for at their speed.
            posture: (n,) measured posture.
            regions: All contacts, the strongest first.
            dt: Time since the last tick [s].
            commanded: (n,) posture commanded at the last tick; None at the first.
        """
        if settings.controller == "impedance":
            return settings, ()
        if self._oscillated is not None and not _same_loop(self._oscillated, settings):
            self._set_full()
        controlled = self._controlled(settings, regions)
        self._measure(posture, regions, controlled, dt, commanded)
        self._watch(settings, regions, dt)
        known = self._update_gains(settings, posture, controlled, dt)
        full, limits = (settings, ()) if known is None else (known.taken, known.limits)
        taken = self._with_reduced_gain(full, dt)
        if taken is not full:
            limits = _changed_gains(settings, taken, self.readings)
        return taken, limits if regions else ()

    def _controlled(self, settings: ControlSettings, regions: Sequence[ContactRegion]) -> list[ContactRegion]:
        """Return the contacts with a force goal: the one controlled before, and all others above the goal."""
        if not regions:
            return []
        first = next((one for one in regions if one.id == self._first), regions[0])
        self._first = first.id
        if settings.controller != "hold_force" and settings.task in ALL_CONTACTS:
            return [first, *(one for one in regions if one.id != first.id)]
        return [first, *self._selection.others(first, regions, settings.force_goal)]

    def _with_reduced_gain(self, settings: ControlSettings, dt: float) -> ControlSettings:
        """Return the settings with the force gain that is reduced after oscillations; it recovers with time."""
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

    def _known(self, settings: ControlSettings, readings: SensorTiming) -> _EffectiveGains | None:
        known = self._current
        if known is None or known.readings != readings or not _same_loop(known.settings, settings):
            return None
        if known.settings is not settings:
            self._current = known = known.for_another_path(settings)
        return known

    def _measure(
        self,
        posture: FloatArray,
        regions: Sequence[ContactRegion],
        controlled: Sequence[ContactRegion],
        dt: float,
        commanded: FloatArray | None,
    ) -> None:
        """Add the motion of the last tick; updates the configuration to ``posture`` if something touches."""
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
            self._contacts[id_] = self._new_contact(felt[id_], felt.keys())
        for id_, contact in self._contacts.items():
            region = felt.get(id_)
            begins = contact.missing == math.inf or before is None
            if region is not None and not begins:
                contact.outward = self._outward(region)
            way = commanded_way = 0.0
            if not begins:
                assert before is not None
                way, commanded_way = (
                    float(contact.outward.dot(now - then))
                    for now, then in zip((posture, commanded), before, strict=True)
                )
            contact.move(way, commanded_way, dt)
            while len(contact.ways) > round(delay / dt) + 1:
                contact.ways.popleft()
            contact.missing = contact.missing + dt if region is None else 0.0
            if region is not None and not begins and region.partner is None and self.readings is not None:
                contact.estimator.look(region.force, way, commanded_way, dt, delay)

    def _new_contact(self, region: ContactRegion, felt: Collection[int]) -> _FollowedContact:
        """Return a new contact; a contact that bounces returns with a new id and keeps its oscillations."""
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
        """Return the outward speed of the contact point per joint velocity (n,)."""
        normal = self._configuration.pose(region.link).rotation.dot(region.link_normal)
        return normal.dot(self._configuration.jacobian(region.link, region.link_position))

    def _watch(self, settings: ControlSettings, regions: Sequence[ContactRegion], dt: float) -> None:
        """Detect oscillations, and halve the gain if it is limited."""
        forces = {region.id: region.force for region in regions}
        swings = [
            contact.detector.look(settings.force_goal, forces.get(id_, 0.0), contact.ways[0], dt)
            for id_, contact in self._contacts.items()
        ]
        found = any(swings)
        quiet = min((contact.detector.quiet for contact in self._contacts.values()), default=math.inf)
        self.oscillates = (found or self.oscillates) and quiet < ENDED
        if found and settings.gains == "limited":
            self.halve(settings)
            for contact in self._contacts.values():
                contact.detector.reset()

    def _update_gains(
        self, settings: ControlSettings, posture: FloatArray, controlled: Sequence[ContactRegion], dt: float
    ) -> _EffectiveGains | None:
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
            known = self._current = _smallest(ids, settings, self.readings, limits)
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
        settling = series
        if slides:  # below the last share, the integral does not grow anyway
            settling = min(series, max(arm.sticking_stiffness, STUCK_SHARE * series))
        return _LoopLimit(stiffness, measured, posture, series, settling, most, min(gain, held))


def _smallest(
    contacts: tuple[int, ...], settings: ControlSettings, readings: SensorTiming, limits: Sequence[_LoopLimit]
) -> _EffectiveGains:
    """Return the gains for which the loops of all contacts are stable."""
    most = min(limit.most for limit in limits)
    if settings.gains != "limited":
        return _EffectiveGains(contacts, settings, readings, most, settings, _unstable(settings, most, readings))
    calm = _limited(settings, readings)
    gain = min(limit.held for limit in limits)
    drawn = LoopFilter.of(calm).position_gain
    integral = max(
        [calm.integral_time, *(_shortest_integral_time(gain, drawn, limit) for limit in limits if limit.measured)]
    )
    calm = replace(calm, force_gain=gain, integral_time=integral)
    return _EffectiveGains(contacts, settings, readings, most, calm, _changed_gains(settings, calm, readings))


def _shortest_integral_time(gain: float, drawn: float, limit: _LoopLimit) -> float:
    """Return the smallest integral time [s] for a damping ratio of 0.7 of  s^2 + (rate + back) s + rate / time.

    The rate at which the force approaches its goal without an integral is gain times stiffness. The point is drawn back
    at a rate ``drawn`` [1/s], less the deflection of soft joints. Near its goal, changes of the force are too small to
    let a contact slide. Where joints hardly move it along the skin, friction then also keeps it from moving outward.
    """
    rate = gain * limit.settling
    back = drawn * limit.settling / limit.stiffness
    return _DAMPED * rate / (rate + back) ** 2 if rate > 0 else 0.0


def _same_loop(one: ControlSettings | None, other: ControlSettings) -> bool:
    """Return whether the settings differ at most in the path, which does not change the stability of the loop.

    A target that is drawn or learned changes the path many times a second.
    """
    if one is None or one is other:
        return one is other
    path = {name: getattr(other, name) for name in _OF_THE_PATH}
    return replace(one, **path) == other


def _limited(settings: ControlSettings, readings: SensorTiming) -> ControlSettings:
    """Return settings with integral and position gain slow enough for the readings, if gains are limited."""
    if settings.gains == "as_given":
        return settings
    wait = readings.period + readings.delay
    place = min(settings.position_gain, PLACE_SHARE / wait)
    integral = max(settings.integral_time, _PATIENCE * wait)
    return replace(settings, position_gain=place, integral_time=integral)


def _unstable(settings: ControlSettings, most: float, readings: SensorTiming) -> tuple[Limit, ...]:
    """Return a limit if a gain that is used as given is above the stability limit."""
    if settings.force_gain <= most:
        return ()
    kind = LimitKind.FORCE_GAIN_UNSTABLE
    period = readings.period
    delay = readings.delay
    return (Limit(kind, value=settings.force_gain, bound=most, period=period, delay=delay),)


def _changed_gains(
    settings: ControlSettings, calm: ControlSettings, readings: SensorTiming | None
) -> tuple[Limit, ...]:
    period, delay = (None, None) if readings is None else (readings.period, readings.delay)
    held = [
        (LimitKind.FORCE_GAIN_HELD, calm.force_gain, settings.force_gain),
        (LimitKind.POSITION_GAIN_HELD, calm.position_gain, settings.position_gain),
    ]
    limits = tuple(
        Limit(kind, value=value, bound=bound, period=period, delay=delay)
        for kind, value, bound in held
        if value < bound
    )
    if calm.force_gain > settings.force_gain:
        return (*limits, Limit(LimitKind.FORCE_GAIN_RAISED, value=calm.force_gain, bound=settings.force_gain))
    return limits
