"""Settings are checked where they come in: from a scene, a recording or a person."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from difflib import get_close_matches
from math import isfinite
from typing import get_args

from app.control.command import ControlSettings, GainsKind, LawName, PathKind, TaskName
from app.errors import SceneError
from app.maps.map_jacobian import JacobianKind

RANGES: dict[str, tuple[float, float]] = {
    "stiffness": (0.5, 40.0),
    "damping_ratio": (0.1, 3.0),
    "force_goal": (0.0, 20.0),
    "force_gain": (0.0, 0.05),
    "integral_time": (0.05, float("inf")),
    "position_gain": (0.0, 20.0),
    "inertia_time": (0.0, 0.5),
    "path_size": (0.005, 0.2),
    "path_speed": (0.0, 0.2),
    "max_force": (1.0, 200.0),
}
"""What a person may set, lowest and highest; the panel's sliders end here."""
CHOICES: dict[str, tuple[str, ...]] = {
    "law": get_args(LawName),
    "task": get_args(TaskName),
    "jacobian": get_args(JacobianKind),
    "gains": get_args(GainsKind),
    "path_kind": get_args(PathKind),
}
"""What a person may choose."""
MOST_POINTS = 2000
"""Of a path."""
MOST_STARTS = 10**9
"""Of a task."""


def check_settings(settings: ControlSettings) -> ControlSettings:
    """Return the settings, or refuse them.

    Raises:
        SceneError: Naming the setting, its value and its range.
    """
    for name, known in CHOICES.items():
        if getattr(settings, name) not in known:
            remedy = f"Choose {', '.join(known[:-1])} or {known[-1]}"
            raise SceneError(
                "the controller does not know that choice",
                place=f"control.{name}",
                value=getattr(settings, name),
                remedy=remedy,
            )
    for name, (low, high) in RANGES.items():
        value = getattr(settings, name)
        if not (isinstance(value, int | float) and low <= value <= high):  # NaN is in no range
            raise SceneError(
                "that setting is out of range",
                place=f"control.{name}",
                value=value,
                remedy=f"Choose {low:g} to {high:g}",
            )
    if type(settings.starts) is not int or not 0 <= settings.starts <= MOST_STARTS:
        raise SceneError(
            "starts are counted", place="control.starts", value=settings.starts, remedy=f"Choose 0 to {MOST_STARTS}"
        )
    _check_path(settings)
    return settings


def _check_path(settings: ControlSettings) -> None:
    path = settings.path
    good = all(len(point) == 2 and all(isinstance(x, int | float) and isfinite(x) for x in point) for point in path)
    if not good or len(path) > MOST_POINTS:
        raise SceneError(
            "that is no path on the map",
            place="control.path",
            value=path[:3],
            remedy=f"Give up to {MOST_POINTS} points of two finite numbers in metres",
        )


def settings_from(values: Mapping[str, object]) -> ControlSettings:
    """Settings from a scene's table.

    Raises:
        SceneError: An unknown key, or a value out of range.
    """
    known = {f.name for f in fields(ControlSettings)}
    unknown = [key for key in values if key not in known]
    if unknown:
        close = get_close_matches(unknown[0], known, n=1)
        hint = f"Did you mean {close[0]}? " if close else ""
        raise SceneError(
            "there is no such controller setting",
            place=f"control.{unknown[0]}",
            value=unknown[0],
            remedy=f"{hint}Choose one of: {', '.join(sorted(known))}",
        )
    try:
        settings = ControlSettings(**values)  # type: ignore[arg-type]
    except TypeError as error:
        remedy = "Give a list of points of two numbers in metres"
        raise SceneError(
            "that is no path on the map", place="control.path", value=values["path"], remedy=remedy
        ) from error
    return check_settings(settings)
