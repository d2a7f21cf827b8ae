"""Stability limits of a sampled force or position loop in closed form.

The loop is an ideal velocity servo on a spring: at each sample the point moves by the gain times an error that is
``delay`` samples old, e[k + 1] = e[k] - L e[k - d], with the loop gain L = gain x stiffness x period.
"""

from __future__ import annotations

import math


def sampled_loop_limit(delay: float) -> float:
    """Greatest stable loop gain with ``delay`` samples: 2 sin(pi / (2 (2 d + 1)))."""
    return 2 * math.sin(math.pi / (2 * (2 * delay + 1)))


def critical_gain(delay: int) -> float:
    """Greatest loop gain without overshoot, that of the double real pole: d^d / (d + 1)^(d + 1)."""
    return float(delay**delay / (delay + 1) ** (delay + 1))
