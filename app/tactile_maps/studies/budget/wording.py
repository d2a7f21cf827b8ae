"""Text of a proposal, for the window and the command line."""

from __future__ import annotations

from tactile_maps.core.reading_units import THIN
from tactile_maps.studies.budget.proposal import Proposal
from tactile_maps.studies.study.work_precision import Setting, Trial, method_title

_UNITS = (("timestep_ms", f"{THIN}ms"), ("pixels", "²"), ("path_speed_mm_s", f"{THIN}mm/s"))


def setting_words(setting: Setting | None) -> str:
    """Return text such as "Implicit fast 2 ms"; a dash for None."""
    if setting is None:
        return "–"
    values = setting.values
    numbers = [f"{number_words(float(values[key]))}{unit}" for key, unit in _UNITS if key in values]
    return " ".join([method_title(setting.method), *numbers])


def proposal_words(found: Proposal, path: Trial | None, *, tried: bool) -> tuple[str, ...]:
    """Return sentences about the cost of the proposal, the most accurate settings, and the controller.

    Args:
        found: The proposal.
        path: Trial of the proposed controller; None without one.
        tried: Whether controllers were tried.
    """
    cost = found.cost
    finest = found.finest
    sentences = [
        f"{number_words(cost.milliseconds)}{THIN}ms a tick; off by {number_words(cost.millimetres)}{THIN}mm, "
        f"{number_words(cost.newtons)}{THIN}N and {100 * cost.pressure:.0f}{THIN}% of the pressure.",
        f"The most accurate settings: {number_words(finest.milliseconds)}{THIN}ms, "
        f"{number_words(finest.millimetres)}{THIN}mm, {number_words(finest.newtons)}{THIN}N, "
        f"{100 * finest.pressure:.0f}{THIN}%.",
    ]
    if path is not None and path.milliseconds is not None:
        sentences.append(f"A path of 30{THIN}mm in {number_words(1e-3 * path.milliseconds)}{THIN}s keeps both limits.")
    elif tried:
        sentences.append("▲ No controller keeps both limits along a path: its setting stays.")
    return tuple(sentences)


def number_words(value: float) -> str:
    """Return three digits; 0 for less than half a thousandth."""
    return "0" if abs(value) < 5e-4 else f"{value:.3g}"
