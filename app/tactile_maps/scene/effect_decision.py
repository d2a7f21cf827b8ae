"""From the needs of a scene and a person's overrides to its effects: what is on, why, and what is missing then.

One small rule an effect, each with its value and the reason in words for a person. A rule knows the needs and the
effects decided above it in the table (``effects.EFFECTS`` has the order). It answers with the value that stands in
``Effects``; for an effect of the sensor that is whether it is on. An override replaces its rule. What a rule cannot
know beforehand its reason names; that of an effect of the sensor also tells its size (``effect_size``).

Warnings tell what a scene switches off although its task needs it, and settings at which its physics is known to be
unsteady (``stability``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from types import MappingProxyType
from typing import Any, TypeAlias

from tactile_maps.core.errors import Finding
from tactile_maps.scene.effect_size import effect_size
from tactile_maps.scene.effects import EFFECTS, EffectEntry, Effects, Override
from tactile_maps.scene.stability import equivalent_stiffness, measured_stability, stability_warning
from tactile_maps.scene.tasks import TASKS, Needs
from tactile_maps.tactile.models.stated_errors import stated_error_text
from tactile_maps.tactile.sensors.sensor_effects import SENSOR_KEYS, SensorEffects

ValueAndReason: TypeAlias = tuple[Any, str]
DecidedAbove: TypeAlias = Mapping[str, Any]
EffectRule: TypeAlias = Callable[[Needs, DecidedAbove], ValueAndReason]
RUBBING_TASKS = ("slide", "push", "self-touch")
"""Tasks in which something slides or sticks on the skin."""
FINE_STEP = 0.001
COARSE_STEP = 0.002
LONGEST_STEP = 0.02
"""Time steps [s]: usual; up to which implicitfast serves where nothing touches; of anything."""


def _dynamics(needs: Needs, _above: DecidedAbove) -> ValueAndReason:
    if needs.task == "view" and "joint_torque" not in needs.outputs:
        return False, "the task is kinematic: joint positions are prescribed"
    return True, f"the task is to {TASKS[needs.task].title}" if needs.task != "view" else "joint torques are an output"


def _fingers(needs: Needs, _above: DecidedAbove) -> ValueAndReason:
    if needs.scripted:
        return True, "the scene has a stimulus script"
    if not needs.attended:
        return False, "no stimulus script and nobody to poke the skin"
    if needs.touch:
        return True, f"the scene outputs {_words(needs.touch)}; whether somebody pokes the skin is not known beforehand"
    return False, "the scene has no tactile output"


def _contact(needs: Needs, above: DecidedAbove) -> ValueAndReason:
    if not above["dynamics"]:
        return "off", "contact needs dynamics"
    itself = needs.task == "self-touch"
    if itself and needs.objects:
        return "all", f"the task is self-contact, and {_names(needs)} in the scene"
    if itself:
        return "self", "the task is self-contact"
    if needs.outside:
        return "environment", f"{_names(needs)} in the scene"
    return ("probe", f"{_names(needs)} in the scene") if needs.probes else ("off", "the scene has no objects")


def _gravity(needs: Needs, above: DecidedAbove) -> ValueAndReason:
    if not above["dynamics"]:
        return "off", "gravity needs dynamics"
    if needs.free:
        return "compensated", f"{needs.free[0]} moves freely; the motors carry the robot's weight"
    if "joint_torque" in needs.outputs:
        return "compensated", "joint torques are an output and include the motors' support"
    return "off", "the motors carry the robot, and nothing else moves freely"


def _friction(needs: Needs, above: DecidedAbove) -> ValueAndReason:
    if above["contact"] == "off":
        return False, "contact is off"
    if needs.task in RUBBING_TASKS:
        return True, f"the task is to {TASKS[needs.task].title}"
    if needs.free:
        return True, f"{needs.free[0]} would slip without friction"
    if "joint_torque" in needs.outputs:
        return True, "joint torques are an output and include friction"
    return False, "the task does not rub, and no object moves freely; whether a contact drags is not known beforehand"


def _joint_limits(_needs: Needs, above: DecidedAbove) -> ValueAndReason:
    return (
        (True, "contact or control may drive joints to their limits; whether they do is not known beforehand")
        if above["dynamics"]
        else (False, "joint positions are prescribed")
    )


def _joint_friction(needs: Needs, above: DecidedAbove) -> ValueAndReason:
    if not above["dynamics"]:
        return False, "joint friction needs dynamics"
    wanted = "joint_torque" in needs.outputs
    return wanted, "joint torques are an output" if wanted else "joint torques are no output"


def _skin(needs: Needs, above: DecidedAbove) -> ValueAndReason:
    if not needs.touch:
        return "off", "the scene has no tactile output"
    untouched = not above["fingers"] and above["contact"] == "off"
    if untouched and (needs.attended or "readings" not in needs.outputs):  # an untouched sensor has noise too
        return "off", "fingers and contact are off"
    model, why = _contact_model(needs)
    judged = needs.touch
    if needs.follows_touch and "posture" in needs.outputs:  # the posture follows the centre too
        judged = tuple(dict.fromkeys((*judged, "centre_of_pressure")))
    return model, f"{why} ({stated_error_text(model, judged)})"


def _contact_model(needs: Needs) -> tuple[str, str]:
    """Return the cheapest contact model whose stated errors serve the outputs, and the reason."""
    if "pressure_shape" in needs.touch:
        return "half-space", "the output is the pressure distribution at the depth of the taxels"
    if "centre_of_pressure" in needs.touch:
        return "punch", "the output is the centre of pressure"
    if needs.touch == ("force",) and not needs.follows_touch:
        return "point", "the output is the force alone, not its distribution"
    return "water-fill", f"the scene outputs {_words(needs.touch)}"


def _time_averaging(needs: Needs, above: DecidedAbove) -> ValueAndReason:
    if above["skin"] == "off":
        return False, "no skin is simulated"
    if "readings" in needs.outputs:
        return True, "the output is sensor readings: a sample takes its time"
    if above["contact"] == "off":
        return False, "only fingers touch, whose force changes slowly"
    if "force" in needs.outputs:
        return True, "the output is force, and an impact may be shorter than a tick"
    return False, "neither force nor readings are an output"


def _timestep(needs: Needs, above: DecidedAbove) -> ValueAndReason:
    if not above["dynamics"]:
        return _part_of(needs.tick, LONGEST_STEP), "without dynamics a step may be as long as a tick"
    return _part_of(needs.tick, FINE_STEP), "short enough for contacts of usual stiffness"


def _integrator(needs: Needs, above: DecidedAbove) -> ValueAndReason:
    if above["dynamics"] and above["timestep"] > COARSE_STEP:
        return "discrete", f"stable at steps longer than {1e3 * COARSE_STEP:g} ms"
    known = measured_stability("implicitfast", above["timestep"], equivalent_stiffness(needs.layer, needs.objects))
    if above["contact"] != "off" and (known is None or known.verdict != "steady"):
        return "discrete", f"stable for contacts as stiff as {needs.layer.stiffness:g} N/m"
    return "implicitfast", "fast, and stable at this step and stiffness"


def _sensor(why: str) -> EffectRule:
    def rule(needs: Needs, above: DecidedAbove) -> ValueAndReason:
        if above["skin"] == "off":
            return False, "no skin is simulated"
        wanted = "readings" in needs.outputs
        return wanted, why if wanted else "sensor readings are no output"

    return rule


def _dead_taxels(_needs: Needs, _above: DecidedAbove) -> ValueAndReason:
    return False, "all taxels work unless the scene sets dead ones"


def _part_of(tick: float, longest: float) -> float:
    """The longest time step up to ``longest`` of which a tick is a whole number."""
    return tick / max(math.ceil(tick / longest - 1e-9), 1)


def _names(needs: Needs) -> str:
    first = needs.objects[0].name
    more = len(needs.objects) - 1
    return f"{first} and {more} more are" if more else f"{first} is"


def _words(outputs: tuple[str, ...]) -> str:
    words = [output.replace("_", " ") for output in outputs]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


_REASONS = {
    "area_averaging": "a taxel averages over its pad",
    "crosstalk": "neighbouring taxels share cover and wiring",
    "hysteresis": "the cover is viscoelastic",
    "gain_spread": "sensitivity varies between taxels",
    "offset_drift": "the zero offset drifts",
    "noise": "amplifiers add noise",
    "saturation": "readings have an upper limit",
    "threshold": "readings below a threshold are zero",
    "quantisation": "readings are digitised",
    "sampling": "readings are slower than control and delayed",
}
_RULES: Mapping[str, EffectRule] = {
    "dynamics": _dynamics,
    "fingers": _fingers,
    "contact": _contact,
    "gravity": _gravity,
    "friction": _friction,
    "joint_limits": _joint_limits,
    "joint_friction": _joint_friction,
    "skin": _skin,
    "time_averaging": _time_averaging,
    "timestep": _timestep,
    "integrator": _integrator,
    "dead_taxels": _dead_taxels,
} | {key: _sensor(f"the output is sensor readings: {why}") for key, why in _REASONS.items()}
EFFECT_RULES: Mapping[str, EffectRule] = MappingProxyType({key: _RULES[key] for key in EFFECTS.built_in})
"""Of the built-in effects; one of a plug-in is off until it is asked for."""


def _plug_in(_needs: Needs, _above: DecidedAbove) -> ValueAndReason:
    return False, "a plug-in adds it, and nobody asked for it"


WarningCheck: TypeAlias = Callable[[Needs, Effects], tuple[str, str] | None]
"""(effect or key, what is lacking and what to do), or None where nothing is."""


def scene_warnings(needs: Needs, effects: Effects) -> tuple[Finding, ...]:
    """Everything that ``needs`` ask for and ``effects`` have not, and the unsteady time step they have, if any."""
    found = (check(needs, effects) for check in _CHECKS)
    findings = tuple(Finding("scene-warning", place, action) for place, action in filter(None, found))
    unsteady = stability_warning(effects, needs.layer, objects=needs.objects)
    return findings if unsteady is None else (*findings, unsteady)


def _nothing_there(needs: Needs, _effects: Effects) -> tuple[str, str] | None:
    if not TASKS[needs.task].objects or needs.outside:
        return None
    return "objects", f"The task is to {TASKS[needs.task].title}, but the scene has no object: add one with [[objects]]"


def _nothing_moves(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if effects.dynamics or (needs.task == "view" and "joint_torque" not in needs.outputs):
        return None
    wants = "to know joint torques" if needs.task == "view" else f"to {TASKS[needs.task].title}"
    return "effects.dynamics", f"Dynamics are off, but the scene is {wants}: switch dynamics on"


def _objects_untouched(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if not effects.dynamics or effects.contact in ("environment", "all"):
        return None
    if needs.outside or (needs.probes and effects.contact != "probe"):
        name = next(spec.name for spec in needs.objects if effects.contact != "probe" or spec.kind != "probe")
        return "effects.contact", f"{name} collides with nothing: choose contact environment or all"
    return None


def _no_self_contact(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if needs.task != "self-touch" or effects.contact in ("self", "all"):
        return None
    return "effects.contact", "The task is self-contact, but self-collision is off: choose contact self"


def _no_friction(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if needs.task not in RUBBING_TASKS or effects.friction:
        return None
    return "effects.friction", f"The task is to {TASKS[needs.task].title}, but friction is off: switch friction on"


def _frictionless_skin(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if not effects.friction or effects.skin != "foundation":
        return None
    problem = "The skin model foundation has no friction"
    return "effects.friction", f"{problem}: choose skin water-fill or switch friction off"


def _nothing_felt(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if not needs.touch or effects.skin != "off":
        return None
    wanted = needs.touch[0].replace("_", " ")
    return "effects.skin", f"The scene outputs {wanted}, but the skin model is off: choose skin water-fill"


def _hand_away(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if not needs.scripted or effects.fingers:
        return None
    return "effects.fingers", "The scene has a stimulus script, but fingers are off: switch fingers on"


def _weightless(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if not (effects.dynamics and needs.free and effects.gravity == "off"):
        return None
    return "effects.gravity", f"{needs.free[0]} does not fall, since gravity is off: choose gravity compensated"


def _ideal_sensor(needs: Needs, effects: Effects) -> tuple[str, str] | None:
    if "readings" not in needs.outputs or any(vars(effects.sensor).values()):
        return None
    return "effects", "The scene outputs sensor readings, but every sensor effect is off: switch one on"


_CHECKS: tuple[WarningCheck, ...] = (
    _nothing_there, _nothing_moves, _objects_untouched, _no_self_contact, _no_friction, _frictionless_skin,
    _nothing_felt, _hand_away, _weightless, _ideal_sensor,
)  # fmt: skip


OVERRIDDEN = "set by the scene"


@dataclass(frozen=True)
class EffectRow:
    """One effect of a scene, for people.

    Attributes:
        name: Its key in ``EFFECTS``.
        title: What people call it.
        on: Whether it costs anything.
        value: The choice, or the number with its unit.
        why: The reason.
        overridden: Whether the scene or a person said so; if not, it follows from the needs.
    """

    name: str
    title: str
    on: bool
    value: str
    why: str
    overridden: bool


@dataclass(frozen=True)
class EffectDecision:
    """What a scene simulates.

    Attributes:
        effects: All of them, decided.
        rows: One an effect, in the order of ``EFFECTS``.
        warnings: What the scene switches off although its task needs it.
    """

    effects: Effects
    rows: tuple[EffectRow, ...]
    warnings: tuple[Finding, ...]


def decide_effects(needs: Needs, overrides: Mapping[str, Override]) -> EffectDecision:
    """Every effect, from an override where there is one, else by its rule.

    Args:
        needs: What the scene is for.
        overrides: By key of ``EFFECTS``, checked; ``auto`` is none.
    """
    values: dict[str, Any] = {}
    reasons: dict[str, str] = {}
    asked = {key for key, override in overrides.items() if override != "auto"}
    for key, entry in EFFECTS.items():
        override = overrides.get(key, "auto")
        value, why = (
            EFFECT_RULES.get(key, _plug_in)(needs, values)
            if override == "auto"
            else (entry.value(override), OVERRIDDEN)
        )
        if entry.of_sensor and isinstance(value, bool):
            value = entry.value("on" if value else "off")
        values[key] = value
        reasons[key] = why
    plug_ins = (value for key, value in values.items() if EFFECTS[key].plug_in is not None and value is not None)
    rows = (_row(EFFECTS[key], values, why, overridden=key in asked) for key, why in reasons.items())
    effects = Effects(
        **{key: value for key, value in values.items() if not EFFECTS[key].of_sensor},
        sensor=SensorEffects(**{key: values[key] for key in SENSOR_KEYS}, plug_ins=tuple(plug_ins)),
    )
    return EffectDecision(effects, tuple(rows), scene_warnings(needs, effects))


def _row(entry: EffectEntry, values: Mapping[str, Any], why: str, *, overridden: bool) -> EffectRow:
    value = values[entry.key]
    word = entry.word(value)
    if entry.of_sensor and value is not None:
        numbers = asdict(value) if entry.plug_in is None else dict(value.options)
        options = ", ".join(f"{key.replace('_', ' ')} {number:g}" for key, number in numbers.items())
        why += f" ({options})" if options else ""
        why += f", worth {effect_size(entry.key, values)}" if entry.plug_in is None else ""
    return EffectRow(entry.key, entry.title, word != "off", word, why, overridden)
