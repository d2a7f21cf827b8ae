"""Which effects a scene calls for: one small rule an effect, each with its value and the reason in words for a person.

A rule knows the needs and the effects decided above it in the table (``effect_table`` has the order). It answers with
the value that stands in ``Effects``; for an effect of the sensor that is whether it is on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, TypeAlias

from app.scene.effect_table import EFFECTS
from app.scene.needs import TASKS, Needs
from app.scene.stability import as_stiff, measured

So: TypeAlias = tuple[Any, str]
Above: TypeAlias = Mapping[str, Any]
Rule: TypeAlias = Callable[[Needs, Above], So]
FINE_STEP, COARSE_STEP, LONGEST_STEP = 0.001, 0.002, 0.02
"""Time steps [s]: usual; up to which implicitfast serves where nothing touches; of anything."""


def _dynamics(needs: Needs, _above: Above) -> So:
    if needs.task == "view" and "joint_torque" not in needs.outputs:
        return False, "the task is to look: the robot is where it is asked to be"
    return True, f"the task is to {TASKS[needs.task].title}" if needs.task != "view" else "joint torques are wanted"


def _fingers(needs: Needs, _above: Above) -> So:
    if needs.scripted:
        return True, "a scripted hand touches the skin"
    if needs.touch:
        return True, f"the scene wants {_words(needs.touch)}, so somebody may touch"
    return False, "the scene wants nothing that is felt"


def _contact(needs: Needs, above: Above) -> So:
    if not above["dynamics"]:
        return "off", "without dynamics nothing can be pushed away"
    itself = needs.task == "self-touch"
    if itself and needs.objects:
        return "all", f"the robot touches itself, and {_names(needs)} there to touch"
    if itself:
        return "self", "the robot touches itself"
    if needs.outside:
        return "environment", f"{_names(needs)} there to touch"
    return ("probe", f"{_names(needs)} there to touch") if needs.probes else ("off", "there is nothing to touch")


def _gravity(needs: Needs, above: Above) -> So:
    if not above["dynamics"]:
        return "off", "without dynamics nothing has weight"
    if needs.free:
        return "compensated", f"{needs.free[0]} rests on something; the robot carries itself"
    if "joint_torque" in needs.outputs:
        return "compensated", "joint torques are wanted, and they carry the robot"
    return "off", "the robot carries its own weight, and nothing else has any"


def _friction(needs: Needs, above: Above) -> So:
    if above["contact"] == "off":
        return False, "no bodies touch"
    if needs.task in ("slide", "push"):
        return True, f"the task is to {TASKS[needs.task].title}"
    if needs.free:
        return True, f"{needs.free[0]} would slip away without"
    if "joint_torque" in needs.outputs:
        return True, "joint torques are wanted, and friction is part of them"
    return False, "nothing slides with a force or lies on anything"


def _joint_limits(_needs: Needs, above: Above) -> So:
    return (True, "a push may reach them") if above["dynamics"] else (False, "the robot is where it is asked to be")


def _joint_friction(needs: Needs, above: Above) -> So:
    if not above["dynamics"]:
        return False, "without dynamics nothing resists"
    wanted = "joint_torque" in needs.outputs
    return wanted, "joint torques are wanted" if wanted else "joint torques are not wanted"


def _skin(needs: Needs, above: Above) -> So:
    if not needs.touch:
        return "off", "the scene wants nothing that is felt"
    if not above["fingers"] and above["contact"] == "off":
        return "off", "nothing can touch the skin"
    if "pressure_shape" in needs.touch:
        return "half-space", "the pressure's shape is wanted as buried taxels feel it"
    if "centre_of_pressure" in needs.touch:
        return "punch", "the centre of pressure is wanted, exactly"
    if needs.touch == ("force",) and needs.law == "impedance":
        return "point", "the scene wants force alone, however it spreads"
    return "water-fill", f"the scene wants {_words(needs.touch)}, and the sum of it exact"


def _timestep(needs: Needs, above: Above) -> So:
    if not above["dynamics"]:
        return _part_of(needs.tick, LONGEST_STEP), "nothing moves by force, so a step is as long as a tick"
    return _part_of(needs.tick, FINE_STEP), "fine enough for the usual contacts"


def _integrator(needs: Needs, above: Above) -> So:
    if above["dynamics"] and above["timestep"] > COARSE_STEP:
        return "discrete", f"steady at steps longer than {1e3 * COARSE_STEP:g} ms"
    known = measured("implicitfast", above["timestep"], as_stiff(needs.layer, needs.objects))
    if above["contact"] != "off" and (known is None or known.verdict != "steady"):
        return "discrete", f"steady where contacts are as stiff as {needs.layer.stiffness:g} N/m"
    return "implicitfast", "cheap, and steady at this step and stiffness"


def _sensor(why: str) -> Rule:
    def rule(needs: Needs, above: Above) -> So:
        if above["skin"] == "off":
            return False, "no skin is simulated"
        wanted = "readings" in needs.outputs
        return wanted, why if wanted else "what electronics would tell is not wanted"

    return rule


def _dead_taxels(_needs: Needs, _above: Above) -> So:
    return False, "a skin is whole unless the scene says otherwise"


def _part_of(tick: float, longest: float) -> float:
    """The longest time step up to ``longest`` of which a tick is a whole number."""
    return tick / max(math.ceil(tick / longest - 1e-9), 1)


def _names(needs: Needs) -> str:
    first, more = needs.objects[0].name, len(needs.objects) - 1
    return f"{first} and {more} more are" if more else f"{first} is"


def _words(outputs: tuple[str, ...]) -> str:
    words = [output.replace("_", " ") for output in outputs]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


_REASONS = {
    "area_averaging": "a real pad has a size",
    "crosstalk": "real pads share a cover and wires",
    "hysteresis": "a real cover creeps",
    "gain_spread": "no two real taxels are alike",
    "offset_drift": "a real zero wanders",
    "noise": "real amplifiers hiss",
    "saturation": "a real taxel has a highest reading",
    "threshold": "faint readings are cut off",
    "quantisation": "a real converter counts in steps",
    "sampling": "a real bus is slower than control, and late",
}
_RULES: Mapping[str, Rule] = {
    "dynamics": _dynamics,
    "fingers": _fingers,
    "contact": _contact,
    "gravity": _gravity,
    "friction": _friction,
    "joint_limits": _joint_limits,
    "joint_friction": _joint_friction,
    "skin": _skin,
    "timestep": _timestep,
    "integrator": _integrator,
    "dead_taxels": _dead_taxels,
} | {key: _sensor(f"readings are wanted: {why}") for key, why in _REASONS.items()}
RULES: Mapping[str, Rule] = MappingProxyType({key: _RULES[key] for key in EFFECTS})
