"""Gains for a skin with slow and delayed readings, and the theoretical minimum time; by the theory of sampled loops.

A sampled integral loop with ``d`` periods of delay has its largest gain without overshoot at L* = d^d / (d+1)^(d+1).
"""

from __future__ import annotations

import math
from dataclasses import replace

from tactile_maps.control.force_loop.sampled_loop import critical_gain
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import INNER_FREQUENCY

STIFFNESS = 2000.0
"""Approximate stiffness of contact and posture loop in series, for the usual cover and a few newtons [N/m]."""
LAG = 2.0 / INNER_FREQUENCY
"""Lag of the posture loop, which is critically damped [s]."""
_FORCE_SHARE = 0.5
"""Share of the largest gain without overshoot for the force: the stiffness of the contact increases with the force."""


def tune_gains(
    settings: ControlSettings, period: float, delay: int, *, stiffness: float = STIFFNESS
) -> ControlSettings:
    """Return the settings with the largest gains without overshoot, and at most the given force gain.

    The loop of the map gets 1 / (T / L* + e LAG): the largest gain L* / T without overshoot of a sampled loop, with the
    lag of the posture loop as an additional dead time, for which it is 1 / (e LAG). The loop of the force gets its
    share of L* / (k T), with the given gain as if it were a lag.

    Args:
        settings: Settings of a controller.
        period: Period of the readings of the skin [s].
        delay: Delay of the readings in periods.
        stiffness: Stiffness of the contact as the controller knows it [N/m].
    """
    wait = period / critical_gain(delay)
    position = 1.0 / (wait + math.e * LAG)
    slower = 1.0 + settings.force_gain * stiffness * wait / _FORCE_SHARE
    return replace(
        settings,
        gains="as_given",
        position_gain=position,
        force_gain=settings.force_gain / slower,
        integral_time=settings.integral_time * slower,
    )


def least_time(length: float, tolerance: float, period: float, delay: int) -> float:
    """Return the minimum time without feed-forward of the speed, l T / (L* e) [s].

    Args:
        length: Length l of the path [m].
        tolerance: Tolerance e [m].
        period: Period T of the readings [s].
        delay: Delay of the readings in periods.
    """
    return length * period / (critical_gain(delay) * tolerance)
