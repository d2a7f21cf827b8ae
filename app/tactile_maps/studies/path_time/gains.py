"""Gains for a skin that is read slowly and late, and the least time that theory allows; by the theory of sampled loops.

A sampled integral loop with ``d`` periods of delay has its greatest gain without overshoot at L* = d^d / (d+1)^(d+1).
"""

from __future__ import annotations

import math
from dataclasses import replace

from tactile_maps.control.force_loop.sampled_loop import critical_gain
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import INNER_FREQUENCY

STIFFNESS = 2000.0
"""Of contact and posture loop in series, about, where the usual cover is pressed with a few newtons [N/m]."""
LAG = 2.0 / INNER_FREQUENCY
"""Of the posture loop, which is critically damped [s]."""
_FORCE_SHARE = 0.5
"""Share of the greatest gain without overshoot that the force gets: contact is stiffer the harder it is pressed."""


def tune_gains(
    settings: ControlSettings, period: float, delay: int, *, stiffness: float = STIFFNESS
) -> ControlSettings:
    """The same settings with gains as high as loops without overshoot allow, and no higher than the given force gain.

    The map's loop gets 1 / (T / L* + e LAG): the greatest gain L* / T without overshoot of a sampled loop, with the
    posture loop's lag as an additional dead time, for which it is 1 / (e LAG). The force's loop gets its share of
    L* / (k T), with the given gain as if it were a lag.

    Args:
        settings: Of a controller.
        period: From one reading of the skin to the next [s].
        delay: Periods by which readings come late.
        stiffness: Of what is pressed, as the controller knows it [N/m].
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
    """Seconds for a path of ``length`` [m] within ``tolerance`` [m], if the controller is not told its speed:
    l T / (L* e).
    """
    return length * period / (critical_gain(delay) * tolerance)
