"""Effects as JSON and back, field by field and strictly: what stands in a recording was written by anyone."""

from __future__ import annotations

import math
from dataclasses import asdict, fields, is_dataclass
from types import NoneType
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from app.scene.effects import Effects

Value = TypeVar("Value")


def effects_to_json(effects: Effects) -> dict[str, Any]:
    """Every field by its name; an effect of the sensor is an object of its options, or null where it is off."""
    return asdict(effects)


def effects_from_json(raw: object) -> Effects:
    """The effects of ``effects_to_json``, equal to the last bit.

    Raises:
        ValueError: A field is missing, unknown or of another kind, or a word is none of those allowed.
        SimulationError: An option of the sensor is out of its range.
    """
    return _read(Effects, raw, "effects")


def _read(kind: type[Value], raw: object, place: str) -> Value:
    """A frozen dataclass from an object that names exactly its fields."""
    names = {field.name for field in fields(kind)}  # type: ignore[arg-type]
    if not isinstance(raw, dict) or raw.keys() != names:
        raise ValueError(f"{place} are not the fields {', '.join(sorted(names))}")
    hints = get_type_hints(kind)
    return kind(**{name: _value(hints[name], value, f"{place}.{name}") for name, value in raw.items()})


def _value(hint: Any, value: object, place: str) -> object:
    if get_origin(hint) is Literal:
        sound = value in get_args(hint)
    elif NoneType in get_args(hint):
        (kind,) = (option for option in get_args(hint) if option is not NoneType)
        return None if value is None else _read(kind, value, place)
    elif is_dataclass(hint):
        return _read(hint, value, place)  # type: ignore[arg-type]
    elif hint is float and type(value) in (int, float):
        value = float(value)  # type: ignore[arg-type]
        sound = math.isfinite(value)
    else:
        sound = type(value) is hint
    if not sound:
        raise ValueError(f"{place} cannot be {value!r}")
    return value
