"""What a scene switches off although its task needs it, and corners where its physics is known to be unsteady."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from app.errors import Finding
from app.scene.effects import Effects
from app.scene.needs import TASKS, Needs
from app.scene.stability import corner

Check: TypeAlias = Callable[[Needs, Effects], tuple[str, str] | None]
"""(effect or key, what is lacking and what to do), or None where nothing is."""


def lacks(needs: Needs, effects: Effects) -> tuple[Finding, ...]:
    """Everything that ``needs`` ask for and ``effects`` have not, and the unsteady corner they are in, if any."""
    found = (check(needs, effects) for check in _CHECKS)
    findings = tuple(Finding("scene-lacks", place, action) for place, action in filter(None, found))
    unsteady = corner(effects, needs.layer, objects=needs.objects)
    return findings if unsteady is None else (*findings, unsteady)


def _nothing_there(needs: Needs, _effects: Effects) -> tuple[str, str] | None:
    if not TASKS[needs.task].objects or needs.outside:
        return None
    return "objects", f"The task is to {TASKS[needs.task].title}, but there is nothing: add one with [[objects]]"


def _nothing_moves(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if effects.dynamics or (needs.task == "view" and "joint_torque" not in needs.outputs):
        return None
    wants = "to know joint torques" if needs.task == "view" else f"to {TASKS[needs.task].title}"
    return "effects.dynamics", f"Without dynamics nothing gives way, but the scene is {wants}: switch dynamics on"


def _objects_untouched(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if not effects.dynamics or effects.contact in ("environment", "all"):
        return None
    if needs.outside or (needs.probes and effects.contact != "probe"):
        name = next(spec.name for spec in needs.objects if effects.contact != "probe" or spec.kind != "probe")
        return "effects.contact", f"{name} is there but nothing touches it: choose contact environment or all"
    return None


def _no_self_contact(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if needs.task != "self-touch" or effects.contact in ("self", "all"):
        return None
    return "effects.contact", "The robot is to touch itself, but its links pass through each other: choose contact self"


def _no_friction(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if needs.task not in ("slide", "push") or effects.friction:
        return None
    return "effects.friction", f"The task is to {TASKS[needs.task].title}, but nothing resists: switch friction on"


def _nothing_felt(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if not needs.touch or effects.skin != "off":
        return None
    wanted = needs.touch[0].replace("_", " ")
    return "effects.skin", f"The scene wants {wanted}, but the skin feels nothing: choose skin water-fill"


def _hand_away(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if not needs.scripted or effects.fingers:
        return None
    return "effects.fingers", "A scripted hand is to touch the skin, but fingers are off: switch fingers on"


def _weightless(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if not (effects.dynamics and needs.free and effects.gravity == "off"):
        return None
    return "effects.gravity", f"{needs.free[0]} floats without gravity: choose gravity compensated"


def _ideal_sensor(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if "readings" not in needs.outputs or any(vars(effects.sensor).values()):
        return None
    return "effects", "Readings of real electronics are wanted, but every effect of the sensor is off: switch one on"


_CHECKS: tuple[Check, ...] = (
    _nothing_there, _nothing_moves, _objects_untouched, _no_self_contact, _no_friction, _nothing_felt, _hand_away,
    _weightless, _ideal_sensor,
)  # fmt: skip
