"""What the panel of behaviours offers, in words: events, answers, durations."""

from __future__ import annotations

from collections.abc import Mapping

from app.control.behaviour import Behaviour

ANYWHERE = "anywhere"
WHEN = {
    ("tap", 1): "tap",
    ("tap", 2): "double tap",
    ("touch", 1): "touch",
    ("press", 1): "press",
    ("stroke", 1): "stroke",
    ("grasp", 1): "grasp",
    ("self-touch", 1): "self-touch",
    ("release", 1): "release",
}
"""Words by event and how often it must happen."""
LASTS = {False: "for good", True: "until released"}
"""Words by whether the settings from before come back."""
_TASKS = {
    "retreat": "retreat",
    "guide": "be guided",
    "keep_force": "keep the force",
    "hold_point": "hold the point",
    "follow_path": "follow the path",
    "balance": "balance contacts",
}
_LAWS = {"impedance": "hold posture", "hold_force": "hold force"}
THEN: list[tuple[dict[str, str], str]] = [
    *(({"law": "hybrid", "task": task}, text) for task, text in _TASKS.items()),
    *(({"law": law}, text) for law, text in _LAWS.items()),
]
"""Settings that change, and their words: the tasks, by a law that does them all, and the two laws without a task."""


def when_words(behaviour: Behaviour) -> str:
    """What must happen, without where."""
    known = WHEN.get((behaviour.on, behaviour.times), f"{behaviour.times} times {behaviour.on}")
    return known + (f" > {behaviour.above:g}\u2009N" if behaviour.above else "")


def then_words(then: Mapping[str, float | str]) -> str:
    """What follows: as the list calls it, else setting by setting."""
    for known, text in THEN:
        if known == dict(then):
            return text
    return ", ".join(f"{name.replace('_', ' ')} {_value(value)}" for name, value in then.items())


def _value(value: float | str) -> str:
    return value.replace("_", " ") if isinstance(value, str) else f"{value:g}"
