"""Numbers as a person writes them: those with a unit are not taken, but told what to write instead."""

from __future__ import annotations

import math
import re
from difflib import get_close_matches

_UNITS: dict[str, dict[str, float]] = {
    "lengths are in metres": {"m": 1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "km": 1e3, "in": 0.0254},
    "masses are in kilograms": {"kg": 1, "g": 1e-3, "mg": 1e-6, "t": 1e3, "lb": 0.45359237},
    "times are in seconds": {"s": 1, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60, "h": 3600},
    "forces are in newtons": {"N": 1, "mN": 1e-3, "kN": 1e3},
    "pressures are in pascals": {"Pa": 1, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "bar": 1e5},
    "stiffness is in newtons per metre": {"N/m": 1, "kN/m": 1e3, "MN/m": 1e6, "N/mm": 1e3, "N/cm": 1e2},
    "speeds are in metres per second": {"m/s": 1, "mm/s": 1e-3, "cm/s": 1e-2},
    "rates are in hertz": {"Hz": 1, "kHz": 1e3},
    "angles are in radians": {"rad": 1, "deg": 0.017453292519943295, "°": 0.017453292519943295},
}
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s].*?)?\s*")


def as_float(value: float) -> float:
    """A number of any size as a float; infinite where it is too large for one."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def number_instead(text: str, *, degrees: bool = False) -> str:
    """A remedy for text where a number belongs, such as "5 mm".

    Args:
        text: What was written.
        degrees: Whether an angle is wanted in degrees there.
    """
    match = _QUANTITY.fullmatch(text)
    if match is None:
        return "Write a number, without quotes"
    number, unit = float(match[1]), match[2]
    if unit is None:
        return f"Write {number:.12g}, without quotes"
    if unit in ("deg", "°") and degrees:
        return f"Angles are in degrees here: write {number:.12g}"
    for words, scales in _UNITS.items():
        if unit in scales:
            return f"{words.capitalize()}: write {number * scales[unit]:.12g}"
    known = [unit for scales in _UNITS.values() for unit in scales]
    close = get_close_matches(unit, known, n=1)
    return "There is no such unit; numbers are in SI units" + (f". Did you mean {close[0]}?" if close else "")
