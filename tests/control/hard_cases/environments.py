"""Hard cases of control: what touches, and what the cover is made of."""

from __future__ import annotations

import numpy as np

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.session.session import Session
from tests.control.hard_cases.case import OTHERS, SOME, STOPPED, HardCase, both, bounded_only, kept, rests
from tests.support.pressed_arm import Course, pressed_by_ball

SWINGS = (LimitKind.OSCILLATION,)


def cover(stiffness: float, depth: float):
    """Return a start at the ball with this stiffness of the cover [N/m] and initial depth [m]."""
    return lambda settings: pressed_by_ball(settings, stiffness=stiffness, depth=depth)


def foam(modulus: float, depth: float):
    """Return a start at the ball with a cover of independent springs of this modulus [Pa]."""
    return lambda settings: pressed_by_ball(
        settings, layer={"modulus": modulus}, overrides={"skin": "foundation"}, depth=depth
    )


def rubbing(friction: float):
    return lambda settings: pressed_by_ball(settings, friction=friction)


def to_and_fro(settings: ControlSettings) -> Session:
    """The ball goes 4 mm in and out, once a second."""
    return pressed_by_ball(settings, way=tuple((0.5 * k, 0.004 * (k % 2)) for k in range(12)))


def along(settings: ControlSettings) -> Session:
    """The ball goes along the skin by 10 mm, to and fro."""
    times = [0.5 * k for k in range(12)]
    return pressed_by_ball(
        settings, way=tuple((t, 0.0) for t in times), along=tuple((t, 0.01 * float(np.sin(1.6 * t))) for t in times)
    )


def follows(within: float):
    """The contact stays near the place it is held at, on the map [m], and the force near its goal."""

    def check(course: Course) -> None:
        assert np.nanpercentile(course.last(course.error, 3.0), 95) < within
        assert course.last(course.pressed, 3.0).mean() == np.clip(course.last(course.pressed, 3.0).mean(), 2.7, 3.3)

    return check


def led(median: float, p95: float, *, force: float = 0.3):
    """The contact goes along its path, at such distances on the map [m], with the force so near its goal [N]."""

    def check(course: Course) -> None:
        steady = course.error[round(1.5 / course.tick) :]
        assert np.nanmedian(steady) < median, np.nanmedian(steady)
        assert np.nanpercentile(steady, 95) < p95, np.nanpercentile(steady, 95)
        assert course.way.max() > 0.02
        assert abs(course.last(course.pressed, 3.0).mean() - 3.0) < force

    return check


PATH = {"task": "follow_path"}
CASES: dict[str, HardCase] = {
    "cover of 1e2 N/m": HardCase(
        "15 mm of cover a newton and a half: the goal is reached, in a second or two, without a swing",
        cover(1e2, 0.004),
        kept(1.0, within=0.08, ripple=0.05),
        {"force_goal": 1.0},
        seconds=4.0,
        force=2.0,
    ),
    "cover of 1e3 N/m": HardCase(
        "the goal is kept",
        cover(1e3, 0.001),
        kept(),
        force=5.0,
        controllers=SOME,
        between=True,
    ),
    "cover of 1e4 N/m": HardCase(
        "the goal is kept",
        cover(1e4, 0.001),
        kept(),
        force=12.0,
        controllers=OTHERS,
        between=True,
    ),
    "cover of 1e5 N/m": HardCase(
        "the goal is kept: the arm's own servo, in series, is what gives",
        cover(1e5, 3e-5),
        kept(),
        force=8.0,
        controllers=SOME,
        between=True,
    ),
    "cover of 1e6 N/m": HardCase(
        "the same",
        cover(1e6, 3e-6),
        kept(),
        force=8.0,
        controllers=OTHERS,
    ),
    "meeting a cover of 1e6 N/m": HardCase(
        "1 mm deep at the start is a blow of a thousand newtons read: the supervisor stops, and the blow passes",
        cover(1e6, 1e-3),
        rests(),
        # The mean of the first tick, before any controller acts: 79.3 N over 5 ms are 0.4 N s. The instantaneous force
        # at its end was below 60 N.
        force=85.0,
        says=(STOPPED,),
        controllers=SOME,
    ),
    "foam of 1e4 Pa": HardCase(
        "the goal is kept",
        foam(1e4, 0.004),
        kept(within=0.3),
        force=5.0,
        controllers=OTHERS,
    ),
    "foam of 1e6 Pa, gain for it": HardCase(
        "springs without damping under the arm's servo: k_f k < 2 w of the servo, kept below",
        foam(1e6, 3e-4),
        kept(),
        {"force_gain": 0.004},
        force=8.0,
        controllers=SOME,
    ),
    "foam of 1e6 Pa, usual gain": HardCase(
        "the usual gain is within that limit too",
        foam(1e6, 3e-4),
        kept(),
        {"force_gain": ControlSettings().force_gain},
        force=8.0,
        controllers=OTHERS,
        between=True,
    ),
    "foam of 1e6 Pa, high gain": HardCase(
        "k_f k = 85/s is above 2 w = 80/s: the force swings, within bounds, and it is said",
        foam(1e6, 3e-4),
        bounded_only,
        {"gains": "as_given"},
        force=40.0,
        seconds=4.0,
        says=(SWINGS,),
        controllers=OTHERS,
    ),
    "foam of 1e6 Pa, high gain held": HardCase(
        "the same gain, not meant as set, is held to what servo and foam can hold: the goal is kept, and it is said",
        foam(1e6, 3e-4),
        kept(),
        force=15.0,
        says=((LimitKind.FORCE_GAIN_HELD,),),
        controllers=OTHERS,
    ),
    "foam of 1e7 Pa, gain for it": HardCase(
        "the goal is kept",
        foam(1e7, 1e-4),
        kept(),
        {"force_gain": 0.003},
        force=10.0,
        controllers=OTHERS,
    ),
    "no friction": HardCase(
        "the path is followed",
        rubbing(0.0),
        led(0.003, 0.008),
        PATH,
        seconds=5.0,
        controllers=SOME,
    ),
    "friction of 0.3": HardCase(
        "the path is followed",
        rubbing(0.3),
        led(0.003, 0.008),
        PATH,
        seconds=5.0,
        controllers=SOME,
        between=True,
    ),
    "friction of 1": HardCase(
        "it sticks until the arm's servo has built up 3 N along the skin, and slips: the path is followed, worse",
        rubbing(1.0),
        led(0.004, 0.010),
        PATH,
        seconds=5.0,
    ),
    "a needle": HardCase(
        "a contact without area, 1 mm wide: its centre stays on a taxel until the next one feels it; bounded and kept",
        lambda settings: pressed_by_ball(settings, radius=0.001, depth=3e-4),
        both(kept(within=0.3, ripple=0.3)),
        PATH,
        seconds=4.0,
        force=8.0,
    ),
    "the ball comes and goes": HardCase(
        "8 mm/s against 3 N: the force is off by the speed over the gain, under half, and right on the mean",
        to_and_fro,
        kept(within=0.4, ripple=1.5, seconds=2.0),
        seconds=5.0,
        force=8.0,
        controllers=OTHERS,
    ),
    "the ball slides along": HardCase(
        "held at a place of the skin, the arm goes along with it",
        along,
        follows(0.004),
        {"task": "hold_point"},
        seconds=5.0,
        force=8.0,
        controllers=SOME,
    ),
    "the ball goes 5 mm away and comes back": HardCase(
        "the contact is sought at the speed of its error, lost, and held again: no kick, no windup",
        lambda settings: pressed_by_ball(settings, leaves=True),
        kept(within=0.2),
        seconds=7.0,
        force=25.0,
        says=((LimitKind.CONTACT_LOST,),),
    ),
}
