"""Gains for a skin that is read slowly and late, by the theory of sampled loops, and how fast a path can then be."""

from __future__ import annotations

import math
from dataclasses import replace

from app.control.command import ControlSettings
from app.control.reference import INNER_FREQUENCY
from app.experiments.sampled_loop import calm_gain

STIFFNESS = 2000.0
"""Of contact and posture loop in series, about, where the usual cover is pressed with a few newtons [N/m]."""
LAG = 2.0 / INNER_FREQUENCY
"""Of the posture loop, which is critically damped [s]."""
_FORCE_SHARE = 0.5
"""Of the greatest calm gain that the force gets: contact is stiffer the harder it is pressed."""


def tuned(settings: ControlSettings, period: float, delay: int) -> ControlSettings:
    """The same settings with gains as high as loops without overshoot allow, and no higher than the given force gain.

    The map's loop gets 1 / (T / L* + e LAG): the sampled loop's calm gain L* / T, with the posture loop's lag as a dead
    time on top, of which 1 / (e LAG) is the calm gain. The force's loop gets its share of L* / (k T), with the given
    gain as if it were a lag.

    Args:
        settings: Of a law.
        period: From one reading of the skin to the next [s].
        delay: Periods by which readings come late.
    """
    wait = period / calm_gain(delay)
    position = 1.0 / (wait + math.e * LAG)
    slower = 1.0 + settings.force_gain * STIFFNESS * wait / _FORCE_SHARE
    return replace(
        settings,
        gains="as_set",
        position_gain=position,
        force_gain=settings.force_gain / slower,
        integral_time=settings.integral_time * slower,
    )


def least_time(length: float, tolerance: float, period: float, delay: int) -> float:
    """Seconds for a path of ``length`` [m] within ``tolerance`` [m], if the law is not told its speed: l T / (L* e)."""
    return length * period / (calm_gain(delay) * tolerance)
