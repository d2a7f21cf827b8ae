"""Decision of the effects of a scene from its needs and the user's overrides, with reasons and warnings.

Each effect has one rule, which returns its value and the reason for the user. A rule receives the needs and the effects
that precede it in ``effects.EFFECTS``. The value is that of ``Effects``; for an effect of the sensor it is whether the
effect is on. An override replaces the rule. Reasons name what cannot be known beforehand; for an effect of the sensor
they also state its size (``effect_size``).

Warnings report effects that a scene switches off although its task needs them, and settings at which the physics is
known to be unsteady (``stability``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from types import MappingProxyType
from typing import Any, TypeAlias

from tactile_maps.core.errors import Finding
from tactile_maps.scene.effect_size import effect_size
from tactile_maps.scene.effects import EFFECTS, EffectEntry, Effects, Override
from tactile_maps.scene.stability import equivalent_stiffness, measured_stability, stability_warning
from tactile_maps.scene.tasks import TASKS, Needs
from tactile_maps.tactile.models.contact_model import WITH_SHEAR
from tactile_maps.tactile.models.stated_errors import stated_error_text
from tactile_maps.tactile.sensors.sensor_effects import SENSOR_KEYS, SensorEffects

ValueAndReason: TypeAlias = tuple[Any, str]
DecidedAbove: TypeAlias = Mapping[str, Any]
EffectRule: TypeAlias = Callable[[Needs, DecidedAbove], ValueAndReason]
RUBBING_TASKS = ("slide", "push", "self-touch")
"""Tasks in which an object slides or sticks on the skin."""
FINE_STEP = 0.001
COARSE_STEP = 0.002
LONGEST_STEP = 0.02
"""Time steps [s]: usual, largest for implicitfast without contact, and largest of all."""


def _dynamics(needs: Needs, _above: DecidedAbove) -> ValueAndReason:
    if needs.task == "view" and "joint_torque" not in needs.outputs:
        return False, "the task is kinematic: joint positions are prescribed"
    return True, f"the task is to {TASKS[needs.task].title}" if needs.task != "view" else "joint torques are an output"


def _fingers(needs: Needs, _above: DecidedAbove) -> ValueAndReason:
    if needs.scripted:
        return True, "the scene has a stimulus script"
    if not needs.attended:
        return False, "no stimulus script and no user to poke the skin"
    if needs.touch:
        return True, f"the scene outputs {_words(needs.touch)}; whether the user pokes the skin is not known beforehand"
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
    if needs.shear:
        return True, _shear_reason(needs)
    if needs.free:
        return True, f"{needs.free[0]} would slip without friction"
    if "joint_torque" in needs.outputs:
        return True, "joint torques are an output and include friction"
    return (
        False,
        "the task has no sliding, and no object moves freely; whether a contact slides is not known beforehand",
    )


def _joint_limits(_needs: Needs, above: DecidedAbove) -> ValueAndReason:
    if not above["dynamics"]:
        return False, "joint positions are prescribed"
    return True, "contact or control may drive joints to their limits; whether they do is not known beforehand"


def _joint_friction(needs: Needs, above: DecidedAbove) -> ValueAndReason:
    if not above["dynamics"]:
        return False, "joint friction needs dynamics"
    if "joint_torque" in needs.outputs:
        return True, "joint torques are an output"
    return False, "joint torques are not an output"


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


def _shear(needs: Needs, above: DecidedAbove) -> ValueAndReason:
    if not needs.shear:
        return False, "no output, behaviour or controller setting needs shear"
    if above["skin"] not in WITH_SHEAR:
        return False, f"the skin model {above['skin']} has no shear" if above[
            "skin"
        ] != "off" else "no skin is simulated"
    return True, _shear_reason(needs)


def _shear_reason(needs: Needs) -> str:
    if "shear" in needs.outputs:
        return "the scene outputs shear"
    return "a behaviour waits for slip" if needs.slip_events else "the controller needs shear"


def _time_averaging(needs: Needs, above: DecidedAbove) -> ValueAndReason:
    if above["skin"] == "off":
        return False, "no skin is simulated"
    if "readings" in needs.outputs:
        return True, "the output is sensor readings: a sample takes time"
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
        if "readings" in needs.outputs:
            return True, why
        return False, "sensor readings are not an output"

    return rule


def _of_axes(why: str) -> EffectRule:
    usual = _sensor(why)

    def rule(needs: Needs, above: DecidedAbove) -> ValueAndReason:
        return usual(needs, above) if above["shear"] else (False, "no shear is simulated")

    return rule


def _dead_taxels(_needs: Needs, _above: DecidedAbove) -> ValueAndReason:
    return False, "all taxels work unless the scene sets dead ones"


def _part_of(tick: float, longest: float) -> float:
    """Return the longest time step up to ``longest`` that divides the tick."""
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
    "shear": _shear,
    "time_averaging": _time_averaging,
    "timestep": _timestep,
    "integrator": _integrator,
    "misorientation": _of_axes("the output is sensor readings: taxels are mounted at an angle"),
    "axis_crosstalk": _of_axes("the output is sensor readings: the channels of a taxel share its elastomer"),
    "dead_taxels": _dead_taxels,
} | {key: _sensor(f"the output is sensor readings: {why}") for key, why in _REASONS.items()}
EFFECT_RULES: Mapping[str, EffectRule] = MappingProxyType({key: _RULES[key] for key in EFFECTS.built_in})
"""Rules of the built-in effects; an effect of a plug-in is off by default."""


def _plug_in(_needs: Needs, _above: DecidedAbove) -> ValueAndReason:
    return False, "a plug-in adds it, and the scene does not set it"


def scene_warnings(needs: Needs, effects: Effects) -> tuple[Finding, ...]:
    """Return a finding for everything that the needs require and the effects lack, and for an unsteady time step."""
    findings = tuple(Finding("scene-warning", place, action) for place, action in _missing(needs, effects))
    unsteady = stability_warning(effects, needs.layer, objects=needs.objects)
    return findings if unsteady is None else (*findings, unsteady)


def _missing(needs: Needs, effects: Effects) -> Iterator[tuple[str, str]]:
    """Yield the key of the scene and the message for each effect or object that is missing."""
    task = TASKS[needs.task]
    if task.objects and not needs.outside:
        yield "objects", f"The task is to {task.title}, but the scene has no object: add one with [[objects]]"
    torques = needs.task == "view"
    if not effects.dynamics and (not torques or "joint_torque" in needs.outputs):
        purpose = "to know joint torques" if torques else f"to {task.title}"
        yield "effects.dynamics", f"Dynamics are off, but the scene is {purpose}: switch dynamics on"
    probe_only = effects.contact == "probe"
    if effects.dynamics and effects.contact not in ("environment", "all"):
        untouched = [spec.name for spec in needs.objects if not (probe_only and spec.kind == "probe")]
        if untouched:
            yield "effects.contact", f"{untouched[0]} collides with nothing: choose contact environment or all"
    if needs.task == "self-touch" and effects.contact not in ("self", "all"):
        yield "effects.contact", "The task is self-contact, but self-collision is off: choose contact self"
    if needs.task in RUBBING_TASKS and not effects.friction:
        yield "effects.friction", f"The task is to {task.title}, but friction is off: switch friction on"
    if effects.friction and effects.skin == "foundation":
        remedy = "choose skin water-fill or switch friction off"
        yield "effects.friction", f"The skin model foundation has no friction: {remedy}"
    if needs.touch and effects.skin == "off":
        output = needs.touch[0].replace("_", " ")
        yield "effects.skin", f"The scene outputs {output}, but the skin model is off: choose skin water-fill"
    if effects.shear and effects.skin not in WITH_SHEAR:
        yield (
            "effects.shear",
            f"The skin model {effects.skin} has no shear: choose skin {' or '.join(WITH_SHEAR[::-1])}",
        )
    if needs.shear and not effects.shear:
        yield "effects.shear", f"Shear is off, but {_shear_reason(needs)}: switch shear on"
    if needs.scripted and not effects.fingers:
        yield "effects.fingers", "The scene has a stimulus script, but fingers are off: switch fingers on"
    if effects.dynamics and needs.free and effects.gravity == "off":
        yield "effects.gravity", f"{needs.free[0]} does not fall, since gravity is off: choose gravity compensated"
    if "readings" in needs.outputs and not any(vars(effects.sensor).values()):
        yield "effects", "The scene outputs sensor readings, but every sensor effect is off: switch one on"


OVERRIDDEN = "set by the scene"


@dataclass(frozen=True)
class EffectRow:
    """Effect of a scene, for display.

    Attributes:
        name: Key in ``EFFECTS``.
        title: Title for the user.
        on: Whether the effect is simulated.
        value: The choice, or the number with its unit.
        why: The reason.
        overridden: Whether the scene or the user set it; otherwise it follows from the needs.
    """

    name: str
    title: str
    on: bool
    value: str
    why: str
    overridden: bool


@dataclass(frozen=True)
class EffectDecision:
    """Effects of a scene with reasons and warnings.

    Attributes:
        effects: The effects.
        rows: One row per effect, in the order of ``EFFECTS``.
        warnings: Effects that the scene switches off although its task needs them.
    """

    effects: Effects
    rows: tuple[EffectRow, ...]
    warnings: tuple[Finding, ...]


def decide_effects(needs: Needs, overrides: Mapping[str, Override]) -> EffectDecision:
    """Decide every effect, from its override or else by its rule.

    Args:
        needs: Needs of the scene.
        overrides: Checked overrides by key of ``EFFECTS``; ``auto`` is no override.
    """
    values: dict[str, Any] = {}
    reasons: dict[str, str] = {}
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
    rows = (_row(EFFECTS[key], values, why, overridden=why == OVERRIDDEN) for key, why in reasons.items())
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
