"""Size of an effect of the sensor relative to the pressure from which a taxel counts as touched, in words.

An effect may be on because readings are an output, and yet change almost nothing. The size states the largest possible
change; the change of a given contact also depends on its pressure, which is not known beforehand.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

LEAST_TOUCH = 1000.0
"""Pressure from which a taxel counts as touched if the sensor has no threshold [Pa]."""

_Size: TypeAlias = Callable[[Any, float], str]


def effect_size(key: str, values: Mapping[str, Any]) -> str:
    """Return the size of one effect of the sensor that is on.

    Args:
        key: Key in ``SensorEffects``.
        values: All effects of the sensor by key; None is off.
    """
    threshold = values.get("threshold")
    return _SIZES[key](values[key], LEAST_TOUCH if threshold is None else max(threshold.at, 1e-9))


def _share(part: float) -> str:
    return f"{100 * part:.2g} %"


def _of_touch(pressure: float, least: float) -> str:
    return f"{_share(pressure / least)} of the least touch ({least:g} Pa)"


def _drift(drift: Any, least: float) -> str:
    start = f"at first {_of_touch(drift.sd, least)}"
    if drift.sd >= least or not drift.walk:
        return start
    seconds = (least**2 - drift.sd**2) / drift.walk**2
    return f"{start}; as large as that after {seconds:.2g} s"


def _saturation(saturation: Any, least: float) -> str:
    return f"nothing below {saturation.at:g} Pa on a taxel, {saturation.at / least:.3g} times the least touch"


def _dead(taxels: Any, least: float) -> str:
    stuck = f"; {_share(taxels.stuck)} read {taxels.stuck_at / least:.3g} times the least touch" if taxels.stuck else ""
    return f"about {_share(taxels.dead)} of a contact's force goes unread{stuck}"


_SIZES: Mapping[str, _Size] = {
    "area_averaging": lambda averaging, _: (
        f"averages details finer than {2e3 * averaging.radius:.2g} mm; pressure between pads is not read"
    ),
    "misorientation": lambda turned, _: f"{_share(turned.sd)} of a taxel's pressure is read as shear, and reversed",
    "axis_crosstalk": lambda mixed, _: f"{_share(mixed.sd)} of a channel is read by another one",
    "crosstalk": lambda crosstalk, _: f"{_share(crosstalk.share)} of a reading; its sum stays",
    "hysteresis": lambda late, _: f"{_share(late.share)} of a change in pressure, gone after {3 * late.seconds:.2g} s",
    "gain_spread": lambda spread, _: f"{_share(spread.sd)} of a taxel's reading",
    "offset_drift": _drift,
    "noise": lambda noise, least: _of_touch(noise.sd, least),
    "saturation": _saturation,
    "threshold": lambda threshold, _: f"at most {threshold.at:g} Pa of a taxel's reading",
    "quantisation": lambda steps, least: f"an rms error of {_of_touch(steps.step / math.sqrt(12), least)}",
    "dead_taxels": _dead,
    "sampling": lambda sampling, _: f"readings up to {1e3 * (1 / sampling.rate + sampling.delay):.3g} ms old",
}
