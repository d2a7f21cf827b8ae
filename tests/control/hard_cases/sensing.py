"""Hard cases of control: readings that come seldom, late, wrong or not at all."""

from __future__ import annotations

import numpy as np

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.force_loop.loop_stability import SensorTiming
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.session.session import Session
from tests.control.hard_cases.case import GOAL, OTHERS, SOME, HardCase, bounded_only, hammering, kept, scaled
from tests.control.hard_cases.environments import led
from tests.support.pressed_arm import Course, forearm, pressed_by_ball

TOO_MUCH = (LimitKind.FORCE_GAIN_UNSTABLE,)
HELD = (LimitKind.FORCE_GAIN_HELD, LimitKind.POSITION_GAIN_HELD)


def sensed(tick: float = 0.005, **overrides):
    """Return a start at the ball with these effects of the sensor."""
    return lambda settings: pressed_by_ball(settings, overrides=overrides, tick=tick)


def read_at(rate: float, delay: int):
    """Return a start at the ball with a skin read at ``rate`` [Hz] and ``delay`` samples late."""
    sampling = {"rate": rate, "delay": delay / rate}
    return sensed(min(0.005, 1 / rate), sampling=sampling)


def _scaled(
    rate: float, delay: int, seconds: float, controllers: tuple[str, ...] = SOME, *, between: bool = False
) -> HardCase:
    readings = SensorTiming(1 / rate, delay / rate)
    settings = scaled(readings)
    stated = f"with gains for {rate:g} Hz and {delay} samples the goal is kept; it takes 4 (d + 1/2) samples and more"
    return HardCase(
        stated,
        read_at(rate, delay),
        kept(within=0.3, ripple=0.3),
        settings,
        seconds=seconds,
        force=8.0,
        controllers=controllers,
        between=between,
    )


def _unscaled(rate: float, delay: int, seconds: float, controllers: tuple[str, ...] = OTHERS) -> HardCase:
    readings = SensorTiming(1 / rate, delay / rate)
    return HardCase(
        "a high gain is beyond the limit of so slow a skin: it hammers no harder than it comes back, and it is said",
        read_at(rate, delay),
        bounded_only,
        {"gains": "as_given"},
        seconds=seconds,
        force=max(hammering(readings), 41.0),
        says=(TOO_MUCH,),
        controllers=controllers,
    )


def _held(rate: float, delay: int, seconds: float, controllers: tuple[str, ...] = SOME) -> HardCase:
    return HardCase(
        "the same high gain, not meant as set, is held to what such a skin can hold: the goal is kept, and it is said",
        read_at(rate, delay),
        kept(within=0.3, ripple=0.3),
        seconds=seconds,
        force=8.0,
        says=(HELD,),
        controllers=controllers,
    )


def swings_less_than(ripple: float, mean: float):
    """A limit cycle no larger than that about the goal [N]."""

    def check(course: Course) -> None:
        pressed = course.last(course.pressed, 2.0)
        assert pressed.std() < ripple, pressed.std()
        assert abs(pressed.mean() - 1.0) < mean, pressed.mean()

    return check


def presses_no_more(course: Course) -> None:
    """The true force does not keep rising although the reading is below the goal."""
    assert course.force[-1] < GOAL
    assert np.ptp(course.last(course.pressed)) < 1.0


def _blind(settings: ControlSettings) -> Session:
    """Return a session at the ball in which all taxels are dead."""
    return pressed_by_ball(settings, overrides={"dead_taxels": {"dead": 1.0}})


def feels_nothing(course: Course) -> None:
    assert not course.force.any()
    home = course.session.prepared.robot.home
    assert np.abs(course.posture[-1] - home).max() < 0.02, "it stays at rest"


def stands(course: Course) -> None:
    """Once it was stopped the arm stays where it is."""
    at = next(
        k for k, why in enumerate(course.said) if any(limit.kind is LimitKind.STOPPED_UNREADABLE for limit in why)
    )
    assert np.abs(course.posture[at:] - course.posture[at]).max() < 0.05


def pressed_twice(settings: ControlSettings) -> Session:
    """Two fingers press the forearm from sides 120 degrees apart, and all that is read of them is their wrench."""
    session = Session(forearm(), scripted=False, settings=settings, reading=ReadingSettings("lumped"))
    for finger, taxel in enumerate((150, 315), start=1):
        session.press(forearm().skin.taxel_point(taxel), force=15.0, finger=finger)
    return session


def stays_slow(course: Course) -> None:
    assert course.pressed.max() > 10, "both press, though the stopped arm gives way"
    assert course.speed.max() < 0.15


SLOW = SensorTiming(0.05, 0.05)
CASES: dict[str, HardCase] = {
    "5 Hz": _scaled(5.0, 0, 7.0, OTHERS, between=True),
    "5 Hz, 5 samples late": _scaled(5.0, 5, 14.0),
    "20 Hz": _scaled(20.0, 0, 3.0, OTHERS),
    "20 Hz, 1 sample late": _scaled(20.0, 1, 4.0, between=True),
    "20 Hz, 2 samples late": _scaled(20.0, 2, 4.0, OTHERS, between=True),
    "20 Hz, 5 samples late": _scaled(20.0, 5, 5.0),
    "100 Hz, 3 samples late": _scaled(100.0, 3, 3.0, OTHERS, between=True),
    "1000 Hz, 5 samples late": _scaled(1000.0, 5, 2.0),
    "5 Hz, high gain": _unscaled(5.0, 0, 4.0),
    "20 Hz, 1 sample late, high gain": _unscaled(20.0, 1, 4.0, SOME),
    "50 Hz, 4 samples late, high gain": _unscaled(50.0, 4, 3.0),
    "5 Hz, gain held": _held(5.0, 0, 7.0),
    "20 Hz, 1 sample late, gain held": _held(20.0, 1, 4.0, OTHERS),
    "50 Hz, 4 samples late, gain held": _held(50.0, 4, 4.0),
    "0.6 of the limit at 20 Hz, 1 sample late": HardCase(
        "k_f k T of 0.6, where 1 is the limit: it rings, and comes to rest",
        read_at(20.0, 1),
        kept(within=0.3, ripple=0.3),
        {**scaled(SLOW, share=0.6), "integral_time": float("inf"), "inertia_time": 0.0},
        seconds=6.0,
        force=12.0,
        controllers=("hybrid", "projection", "priority", "admittance"),
    ),
    "1.7 times the limit at 20 Hz, 1 sample late": HardCase(
        "it swings, no harder than it comes back, and both is said",
        read_at(20.0, 1),
        bounded_only,
        {**scaled(SLOW, share=1.7), "integral_time": float("inf"), "inertia_time": 0.0},
        seconds=5.0,
        force=41.0,
        says=(TOO_MUCH, (LimitKind.OSCILLATION, LimitKind.CONTACT_LOST)),
        controllers=("hybrid", "projection", "priority", "admittance"),
    ),
    "two touches, one wrench": HardCase(
        "no contact explains the wrench: the arm is stopped before it moves at 0.15 rad/s, where it would come to 0.8",
        pressed_twice,
        stays_slow,
        {"task": "hold_point", "position_gain": 20.0},
        seconds=3.0,
        force=41.0,
        says=((LimitKind.STOPPED_BY_MISMATCH,),),
    ),
    "a threshold near the goal": HardCase(
        "1 N over the taxels that 2.5 kPa leave: found and lost by turns at worst, a limit cycle of less than 1.5 N",
        sensed(threshold={"at": 2500.0}),
        swings_less_than(1.5, 0.6),
        {"force_goal": 1.0},
        seconds=5.0,
        force=8.0,
        controllers=SOME,
    ),
    "a threshold above what the goal makes": HardCase(
        "0.3 N make no taxel read 2.5 kPa: at worst a limit cycle between nothing and the first taxel's newton",
        sensed(threshold={"at": 2500.0}),
        bounded_only,
        {"force_goal": 0.3},
        seconds=5.0,
        force=8.0,
        controllers=OTHERS,
    ),
    "saturation": HardCase(
        "a plateau of 2 kPa reads less than the goal however hard it is pressed: the arm presses no more, and says why",
        sensed(saturation={"at": 2000.0}),
        presses_no_more,
        seconds=10.0,
        force=30.0,
        says=((LimitKind.SKIN_SATURATED,),),
    ),
    "noise of 10 %": HardCase(
        "white noise of 500 Pa: kept on the mean",
        sensed(noise={"sd": 500.0}),
        kept(within=0.3, ripple=0.6),
        force=8.0,
        controllers=OTHERS,
    ),
    "gains spread, offsets drift": HardCase(
        "what is read wrong is kept wrong, and costs no time",
        sensed(gain_spread="on", offset_drift="on"),
        kept(within=0.6, ripple=0.2),
        force=8.0,
        controllers=SOME,
    ),
    "20 % dead taxels on the path": HardCase(
        "centres of pressure jump by part of a pitch; force is read too low, so it presses 2 N more on the mean",
        sensed(dead_taxels={"dead": 0.2}),
        led(0.006, 0.016, force=3.0),
        {"task": "follow_path"},
        seconds=6.0,
        force=20.0,
    ),
    "a patch that is dead": HardCase(
        "nothing is felt: the arm stays at rest",
        _blind,
        feels_nothing,
        controllers=OTHERS,
    ),
}
