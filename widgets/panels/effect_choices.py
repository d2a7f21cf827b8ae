"""What a person may set an effect to, in words, and what its row says. No Qt."""

from __future__ import annotations

from dataclasses import replace

from app.scene.decide import Decision, EffectRow
from app.scene.effect_table import EFFECTS, EffectEntry, Wish
from app.scene.effects import Effects
from app.scene.scene import Scene, with_wish

AUTO = "auto"
_STEPS = (0.0005, 0.001, 0.002, 0.0025, 0.004, 0.005, 0.008, 0.01, 0.02)
"""Time steps that are offered [s], where a tick is a whole number of them."""
Choices = tuple[tuple[str, Wish], ...]


def choices_of(key: str, *, tick: float) -> Choices:
    """(words, wish) of all that an effect may be set to, ``auto`` first.

    Args:
        key: Of ``effect_table``.
        tick: Of the scene [s].
    """
    entry = EFFECTS[key]
    if entry.choices:
        return (("Auto", AUTO), *((choice, choice) for choice in entry.choices))
    return (("Auto", AUTO), *((entry.word(step), step) for step in _steps(entry, tick)))


def _steps(entry: EffectEntry, tick: float) -> list[float]:
    low, high = entry.range
    return [step for step in _STEPS if low <= step <= high and abs(tick / step - round(tick / step)) < 1e-6]


def autos_of(scene: Scene) -> dict[str, EffectRow]:
    """Each effect as it would be if it alone followed from what the scene is for. Cost: 0.1 ms a wish."""
    rows = {row.name: row for row in scene.decision.rows}
    for key in scene.wishes:
        auto = with_wish(scene, key, AUTO).decision
        rows[key] = next(row for row in auto.rows if row.name == key)
    return rows


def recorded(scene: Scene, effects: Effects) -> Decision:
    """What is simulated, where that may differ from what the scene decides: it was changed while it was recorded."""
    decision = scene.decision
    if effects == decision.effects:
        return decision
    rows = []
    for row in decision.rows:
        entry = EFFECTS[row.name]
        old, new = (getattr(part.sensor if entry.sensor else part, row.name) for part in (decision.effects, effects))
        word = entry.word(new)
        changed = replace(row, on=word != "off", value=word, why="changed while it ran", wished=True)
        rows.append(row if old == new else changed)
    return Decision(effects, tuple(rows), ())


def chosen(decision: Decision, opened: Scene, scene: Scene) -> Decision:
    """The same decision, with a person named where it was not the scene that was opened who said so."""
    here = {key for key, wish in scene.wishes.items() if opened.wishes.get(key) != wish}
    rows = (replace(row, why="you chose so") if row.name in here else row for row in decision.rows)
    return replace(decision, rows=tuple(rows))


def tip_of(row: EffectRow, auto: EffectRow) -> str:
    """What the effect does, and why it is as it is; of one that is off also what it would usually be."""
    entry = EFFECTS[row.name]
    usual = ", ".join(f"{key.replace('_', ' ')} {value:g}" for key, value in entry.options.items())
    off = f"\nUsually {usual}." if usual and not row.on else ""
    return f"{entry.tip}.\n{reason_of(row, auto)}{off}"


def reason_of(row: EffectRow, auto: EffectRow) -> str:
    """The reason in a sentence; of what was wished also what it would be by itself, and why."""
    why = row.why[:1].upper() + row.why[1:]
    return f"{why}; auto is {auto.value}: {auto.why}." if row.wished else f"{why}."
