"""From needs and wishes to effects: what is on, why, and what the scene lacks for its task."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from app.errors import Finding
from app.scene.effect_table import EFFECTS, SENSOR_KEYS, EffectEntry, Wish
from app.scene.effects import Effects
from app.scene.lacks import lacks
from app.scene.needs import Needs
from app.scene.rules import RULES
from app.touch.sensor.effects import SensorEffects

WISHED = "the scene says so"


@dataclass(frozen=True)
class EffectRow:
    """One effect of a scene, for people.

    Attributes:
        name: Its key in ``effect_table``.
        title: What people call it.
        on: Whether it costs anything.
        value: The choice, or the number with its unit.
        why: The reason.
        wished: Whether the scene or a person said so; if not, it follows from the needs.
    """

    name: str
    title: str
    on: bool
    value: str
    why: str
    wished: bool


@dataclass(frozen=True)
class Decision:
    """What a scene simulates.

    Attributes:
        effects: All of them, decided.
        rows: One an effect, in the order of ``effect_table``.
        warnings: What the scene switches off although its task needs it.
    """

    effects: Effects
    rows: tuple[EffectRow, ...]
    warnings: tuple[Finding, ...]


def decide(needs: Needs, wishes: Mapping[str, Wish]) -> Decision:
    """Every effect, from a wish where there is one, else by its rule.

    Args:
        needs: What the scene is for.
        wishes: By key of ``effect_table``, checked; ``auto`` is no wish.
    """
    values: dict[str, Any] = {}
    rows = []
    for key, entry in EFFECTS.items():
        wish = wishes.get(key, "auto")
        value, why = RULES[key](needs, values) if wish == "auto" else (entry.value(wish), WISHED)
        if entry.sensor is not None and isinstance(value, bool):
            value = entry.sensor() if value else None
        values[key] = value
        rows.append(_row(entry, value, why, wished=wish != "auto"))
    effects = Effects(
        **{key: value for key, value in values.items() if key not in SENSOR_KEYS},
        sensor=SensorEffects(**{key: values[key] for key in SENSOR_KEYS}),
    )
    return Decision(effects, tuple(rows), lacks(needs, effects))


def _row(entry: EffectEntry, value: Any, why: str, *, wished: bool) -> EffectRow:
    word = entry.word(value)
    if entry.sensor is not None and value is not None:
        options = (f"{key.replace('_', ' ')} {number:g}" for key, number in asdict(value).items())
        why += f" ({', '.join(options)})"
    return EffectRow(entry.key, entry.title, word != "off", word, why, wished)
