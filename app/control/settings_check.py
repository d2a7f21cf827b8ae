"""The check of settings where they come in: from a scene, a recording or a person."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite

from app.control.command import (
    CHOICES,
    MOST_POINTS,
    MOST_STARTS,
    RANGES,
    ControlSettings,
    is_number,
    range_remedy,
)
from app.control.controller_registry import CONTROLLERS
from app.core.errors import SceneError
from app.core.toml import check_keys


def check_settings(settings: ControlSettings) -> ControlSettings:
    """Return the settings, or refuse them.

    Raises:
        SceneError: Naming the setting, its value and its range.
    """
    for name, known in CHOICES.items():
        value = getattr(settings, name)
        if value not in known and not (name == "controller" and value in CONTROLLERS):
            remedy = f"Choose {', '.join(known[:-1])} or {known[-1]}"
            if name == "controller":
                remedy = CONTROLLERS.remedy(str(value))
            raise SceneError(
                "the controller does not know that choice", place=f"control.{name}", value=value, remedy=remedy
            )
    for name, (low, high) in RANGES.items():
        value = getattr(settings, name)
        if not low <= value <= high:  # NaN is in no range
            raise SceneError(
                "that setting is out of range", place=f"control.{name}", value=value, remedy=range_remedy(name)
            )
    if type(settings.starts) is not int or not 0 <= settings.starts <= MOST_STARTS:
        raise SceneError(
            "the number of starts is out of range",
            place="control.starts",
            value=settings.starts,
            remedy=f"Choose 0 to {MOST_STARTS}",
        )
    _check_path(settings)
    return settings


def _check_path(settings: ControlSettings) -> None:
    path = settings.path
    good = all(len(point) == 2 and all(is_number(x) and isfinite(x) for x in point) for point in path)
    if not good or len(path) > MOST_POINTS:
        raise SceneError(
            "this is not a path on the map",
            place="control.path",
            value=path[:3],
            remedy=f"Give up to {MOST_POINTS} points of two finite numbers in metres",
        )


def settings_from(values: Mapping[str, object]) -> ControlSettings:
    """Settings from a scene's table.

    Raises:
        SceneError: An unknown key, or a value out of range.
    """
    check_keys(values, ControlSettings, place="control")
    try:
        settings = ControlSettings(**values)  # type: ignore[arg-type]
    except TypeError as error:
        remedy = "Give a list of points of two numbers in metres"
        raise SceneError(
            "this is not a path on the map", place="control.path", value=values["path"], remedy=remedy
        ) from error
    return check_settings(settings)
