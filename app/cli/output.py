"""What the command line says: facts on standard output, progress and failures on standard error."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import is_dataclass
from typing import Any

from app.core.progress import Progress
from app.recording.damage import RecordingDamage, damage_text


def print_line(text: str) -> None:
    """One line for a person."""
    sys.stdout.write(text + "\n")


def print_fields(rows: Mapping[str, object]) -> None:
    """Aligned facts for a person."""
    width = max((len(name) for name in rows), default=0)
    for name, value in rows.items():
        print_line(f"{name:<{width}}  {plain_text(value)}")


def plain_text(value: object) -> str:
    """A fact as a person reads it: numbers with four digits, what belongs together with commas between."""
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, dict):
        return ", ".join(f"{key} {plain_text(item)}" for key, item in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(plain_text(item) for item in value)
    return str(value)


def damage_rows(damage: Sequence[RecordingDamage], tick: float) -> dict[str, object]:
    """Whether a recording is complete and what it has lost, as facts for ``print_fields``; its tick in seconds."""
    if not damage:
        return {"Complete": "yes"}
    return {"Complete": "no", "Damage": "; ".join(damage_text(one, tick) for one in damage)}


def print_json(result: Mapping[str, Any]) -> None:
    """One object on one line, for a program; what JSON cannot say (NaN, infinity) becomes null."""
    sys.stdout.write(json.dumps(_json_value(result), allow_nan=False) + "\n")


def print_error(text: str) -> None:
    """A failure, on standard error."""
    sys.stderr.write(f"tactile-maps: {text}\n")


def print_warning(text: str) -> None:
    """Something a person should know although the work goes on, on standard error."""
    sys.stderr.write(f"tactile-maps: warning: {text}\n")


def progress_line() -> Progress:
    """Progress on one line of a terminal; nothing where standard error is a file."""
    if not sys.stderr.isatty():
        return lambda _text, _fraction: None

    def report(text: str, fraction: float) -> None:
        sys.stderr.write(f"\r\x1b[K{100 * fraction:3.0f} %  {text}")
        if fraction >= 1.0:
            sys.stderr.write("\r\x1b[K")
        sys.stderr.flush()

    return report


def _json_value(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _json_value(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_json_value(item) for item in value]
    if is_dataclass(value) and not isinstance(value, type):
        return _json_value(vars(value))
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if hasattr(value, "item"):
        return _json_value(value.item())
    return value
