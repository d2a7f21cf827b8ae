"""How well a contact's force is told, in words that a researcher reads."""

from __future__ import annotations

import math

from app.contacts.estimators.estimate import ForceEstimate


def estimate_words(estimate: ForceEstimate) -> str:
    """Like "12 of 14 told apart, residual 1.1 noise", with condition, peak and mean below; or why it was refused."""
    told, condition = f"{estimate.effective_rank} of {estimate.unknowns} told apart", _number(estimate.condition)
    if estimate.refused:
        return f"{told}, condition {condition}\nRefused: {estimate.refused[:1].lower()}{estimate.refused[1:]}"
    if not len(estimate.forces):  # there is no distribution to explain readings with
        return f"Force and torque: {told}\nOne force at one place, without a shape"
    peak, mean = 1e-3 * estimate.peak, 1e-3 * estimate.mean
    return f"{told}, {_residual(estimate)}\nCondition {condition}, peak {peak:.1f} and mean {mean:.1f}\u2009kPa"


def _residual(estimate: ForceEstimate) -> str:
    if estimate.noise > 0:
        return f"residual {_number(estimate.misfit)}\u2009noise"
    return f"residual {1e-3 * estimate.residual:.2g}\u2009kPa"


def _number(value: float) -> str:
    if not math.isfinite(value):
        return "∞"
    return f"{value:.2g}" if value < 100 else f"{value:.0f}" if value < 1e4 else f"{value:.0e}"
