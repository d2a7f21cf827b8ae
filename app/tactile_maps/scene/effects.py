"""Effects that a scene may simulate: the selected effects as a value, and the table of all effects.

Effects that are off in ``Effects`` are not part of the model or the loop and cost nothing. ``EFFECTS`` lists every
effect with its title, its choices and its usual value. An effect may depend on those that precede it in the table.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal, TypeAlias, get_args, get_type_hints

from tactile_maps.core.errors import SceneError, SimulationError, did_you_mean
from tactile_maps.core.toml import as_float, number_remedy
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS, IN_PHYSICS
from tactile_maps.tactile.sensors.sensor_chain import SENSOR_STAGES, SensorStageEntry
from tactile_maps.tactile.sensors.sensor_effects import SENSOR_KEYS, SensorEffects

Gravity: TypeAlias = Literal["off", "on", "compensated"]
ContactScope: TypeAlias = Literal["off", "probe", "environment", "self", "all"]
SkinModel: TypeAlias = Literal["off", "point", "water-fill", "punch", "half-space", "foundation", "depth"]
Integrator: TypeAlias = Literal["implicitfast", "discrete", "euler", "implicit"]


@dataclass(frozen=True)
class Effects:
    """The effects of one scene.

    Attributes:
        gravity: ``compensated`` adds gravity and an ideal compensation of it in the robot; ``off`` has neither.
        contact: Bodies that can touch: ``probe`` the skin and probes; ``environment`` robot, probes and objects;
            ``self`` the robot's own links; ``all`` everything; ``off`` compiles no colliding geometry.
        joint_limits: Whether joints stop at their limits.
        timestep: Time step of the integrator [s].
        dynamics: Whether bodies have inertia; otherwise the robot is exactly at its target, and nothing pushes it.
        fingers: Whether the user and scripts may poke.
        friction: Whether contacts resist sliding.
        joint_friction: Whether joints have the dry friction that the robot's file states.
        skin: Contact model, which turns contact into pressure: a ``SkinModel`` or that of a plug-in; ``off`` senses
            nothing.
        shear: Whether taxels are sheared by friction, and fingers can drag the skin.
        time_averaging: Whether a reading is the mean since the previous one, not the value at the last time step.
        integrator: Integrator of MuJoCo.
        sensor: Effects of the sensor on the pressure.

    Raises:
        SceneError: The contact model or an effect of the sensor is unknown.
    """

    gravity: Gravity = "compensated"
    contact: ContactScope = "off"
    joint_limits: bool = True
    timestep: float = 0.001
    dynamics: bool = True
    fingers: bool = True
    friction: bool = False
    joint_friction: bool = False
    skin: str = "water-fill"
    shear: bool = False
    time_averaging: bool = False
    integrator: Integrator = "implicitfast"
    sensor: SensorEffects = field(default_factory=SensorEffects)

    def __post_init__(self) -> None:
        if self.skin not in ("off", *IN_PHYSICS) and self.skin not in CONTACT_MODELS:
            remedy = CONTACT_MODELS.remedy(self.skin)
            raise SceneError("unknown contact model", place="effects.skin", value=self.skin, remedy=remedy)
        for effect in self.sensor.plug_ins:
            if effect.name not in SENSOR_STAGES:
                remedy = SENSOR_STAGES.remedy(effect.name)
                raise SceneError("unknown effect", place="effects", value=effect.name, remedy=remedy)


Override: TypeAlias = str | float | Mapping[str, float]
"""Setting of an effect: a word, a number, or a table of numbers for an effect of the sensor."""

_SWITCH = ("off", "on")
_SENSORS: Mapping[str, type] = {
    name: next(kind for kind in get_args(hint) if kind is not type(None))
    for name, hint in get_type_hints(SensorEffects).items()
    if name in SENSOR_KEYS
}


@dataclass(frozen=True)
class EffectEntry:
    """An effect that a scene can choose.

    Attributes:
        key: Key in scene files and in ``Effects`` or ``SensorEffects``.
        title: Title for the user.
        tip: Description in one sentence.
        words: Possible words besides ``auto``, without those of plug-ins; none for a number.
        when_on: The word that switches it on; empty if it cannot be off.
        range: Lowest and highest value of a number.
        unit: Unit of a number.
        plug_in: Entry of an effect of the sensor that a plug-in adds.
    """

    key: str
    title: str
    tip: str
    words: tuple[str, ...] = _SWITCH
    when_on: str = "on"
    range: tuple[float, float] = (-math.inf, math.inf)
    unit: str = ""
    plug_in: SensorStageEntry | None = None

    @property
    def of_sensor(self) -> bool:
        """Whether it is an effect of the sensor, built in or of a plug-in."""
        return self.sensor is not None or self.plug_in is not None

    @property
    def choices(self) -> tuple[str, ...]:
        """Possible words besides ``auto``, those of plug-ins at the end; none for a number."""
        if self.key != "skin":
            return self.words
        return (*self.words, *(name for name in CONTACT_MODELS if name not in self.words))

    def _knows(self, word: str) -> bool:
        return word in self.words or (self.key == "skin" and word in CONTACT_MODELS)

    @property
    def sensor(self) -> type | None:
        """Type of the options of a built-in effect of the sensor."""
        return _SENSORS.get(self.key)

    @property
    def options(self) -> dict[str, float]:
        """Names and default values of its options; only effects of the sensor have options."""
        if self.plug_in is not None:
            return {option.name: option.usual for option in self.plug_in.options}
        return asdict(self.sensor()) if self.sensor is not None else {}

    def checked(self, override: Override | bool) -> Override:
        """Return the override in its standard form: ``true`` becomes ``on``, an integer a float.

        Raises:
            SceneError: The value is not possible; place, choices and the nearest spelling are named.
        """
        if isinstance(override, bool):
            override = "on" if override else "off"
        if override == "auto" or (isinstance(override, str) and self._knows(override)):
            return override
        if isinstance(override, Mapping) and self.of_sensor:
            return self._checked_options(override)
        if isinstance(override, int | float) and not self.words and self.range[0] <= override <= self.range[1]:
            return float(override)
        problem = f"unknown value of {self.key}"
        if not self.words and isinstance(override, int | float):
            problem = f"{self.key} is out of range"
        raise SceneError(problem, place=f"effects.{self.key}", value=override, remedy=self._allowed(override))

    def value(self, override: Override) -> Any:
        """Return the value in ``Effects`` or ``SensorEffects`` of a checked override other than ``auto``."""
        if self.of_sensor:
            numbers = override if isinstance(override, Mapping) else {}
            return self._effect(numbers) if override == "on" or isinstance(override, Mapping) else None
        return override == "on" if self.words == _SWITCH else override

    def override(self, value: Any) -> Override:
        """Return the override that results in a value of ``Effects`` or ``SensorEffects``; the inverse of ``value``."""
        if self.of_sensor and value is not None:
            return dict(value.options) if self.plug_in is not None else asdict(value)
        return self.word(value) if self.of_sensor or self.words else float(value)

    def word(self, value: Any) -> str:
        """Return the word of a value of ``Effects``, or its number with the unit."""
        if self.of_sensor:
            return "off" if value is None else "on"
        if self.words == _SWITCH:
            return "on" if value else "off"
        return str(value) if self.words else f"{value:g} {self.unit}"

    def value_in(self, effects: Effects) -> Any:
        """Return its value in ``effects``."""
        return effects.sensor.of(self.key) if self.of_sensor else getattr(effects, self.key)

    def _effect(self, numbers: Mapping[str, float]) -> Any:
        """Return the effect of the sensor with these options."""
        if self.plug_in is not None:
            return self.plug_in.effect(numbers)
        assert self.sensor is not None
        return self.sensor(**numbers)

    def _checked_options(self, override: Mapping[str, float]) -> Mapping[str, float]:
        for key, value in override.items():
            place = f"effects.{self.key}.{key}"
            if key not in self.options:
                remedy = did_you_mean(key, tuple(self.options))
                raise SceneError("unknown option", place=place, value=key, remedy=remedy)
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(as_float(value)):
                instead = number_remedy(value) if isinstance(value, str) else None
                raise SceneError("this must be a number", place=place, value=value, remedy=instead)
        numbers = {key: float(value) for key, value in override.items()}
        try:
            self.value(numbers)
        except SimulationError as error:  # the options know their ranges
            option = next((key for key in numbers if key in str(error.place).split(".")), "")
            place = ".".join(filter(None, ("effects", self.key, option)))
            raise error.at(kind=SceneError, place=place) from error
        return numbers

    def _allowed(self, override: object) -> str:
        if not self.words:
            instead = f"{number_remedy(override)}. " if isinstance(override, str) else ""
            return f"{instead}Choose auto, or {self.range[0]:g} to {self.range[1]:g} {self.unit}"
        table = f", or a table of {', '.join(self.options)}" if self.options else ""
        near = did_you_mean(str(override), ("auto", *self.choices)) + table
        return f"{near}, or install the plug-in that adds it" if self.key == "skin" else near


def effect_entry(key: str) -> EffectEntry:
    """Return the effect of that key.

    Raises:
        SceneError: The key is unknown; the nearest spelling is named.
    """
    if key not in EFFECTS:
        broken = any(one.name == key and one.problem is not None for one in SENSOR_STAGES.plugins())
        install = f"{did_you_mean(key, tuple(EFFECTS))}, or install the plug-in that adds it"
        remedy = SENSOR_STAGES.remedy(key) if broken else install
        raise SceneError("unknown effect", place=f"effects.{key}", value=key, remedy=remedy)
    return EFFECTS[key]


_ENTRIES = (
    EffectEntry("dynamics", "Dynamics", "Bodies have inertia and move under forces"),
    EffectEntry("fingers", "Fingers", "The mouse and stimulus scripts can poke the skin"),
    EffectEntry(
        "contact",
        "Contact",
        "Which bodies collide: probes, objects, the robot's own links",
        get_args(ContactScope),
        "all",
    ),
    EffectEntry(
        "gravity",
        "Gravity",
        "Gravity; compensated: the motors carry the robot's own weight",
        get_args(Gravity),
        "compensated",
    ),
    EffectEntry("friction", "Friction", "Coulomb friction at contacts"),
    EffectEntry("joint_limits", "Joint limits", "Joints stop at their position limits"),
    EffectEntry("joint_friction", "Joint friction", "Dry friction of the joints, as the robot file states it"),
    EffectEntry("skin", "Skin", "How contact forces become taxel pressures", get_args(SkinModel), "water-fill"),
    EffectEntry("shear", "Shear", "How friction shears the taxels, for skins that measure three axes"),
    EffectEntry("time_averaging", "Time averaging", "A reading is the mean since the last one, so impulses count"),
    EffectEntry("timestep", "Time step", "Time step of the physics", (), "", (1e-5, 0.02), "s"),
    EffectEntry("integrator", "Integrator", "Numerical integrator of the physics", get_args(Integrator), ""),
    EffectEntry("area_averaging", "Area averaging", "A taxel reads the mean pressure over its pad, not at a point"),
    EffectEntry("misorientation", "Misorientation", "The frames of three-axis taxels differ from the stated ones"),
    EffectEntry("axis_crosstalk", "Axis crosstalk", "Pressure and shear of a three-axis taxel leak into each other"),
    EffectEntry("crosstalk", "Crosstalk", "Part of each reading leaks to neighbouring taxels"),
    EffectEntry("hysteresis", "Hysteresis", "Viscoelastic cover: readings lag on loading and unloading"),
    EffectEntry("gain_spread", "Gain spread", "Sensitivity varies between taxels"),
    EffectEntry("offset_drift", "Offset drift", "The reading at zero pressure is offset and drifts"),
    EffectEntry("noise", "Noise", "Random noise on each reading"),
    EffectEntry("saturation", "Saturation", "Readings are clipped at a maximum pressure"),
    EffectEntry("threshold", "Threshold", "Readings below the threshold are zero"),
    EffectEntry("quantisation", "Quantisation", "Readings have the resolution of the A/D converter"),
    EffectEntry("dead_taxels", "Dead taxels", "Some taxels read zero or a constant value"),
    EffectEntry("sampling", "Sampling", "Readings have a lower rate than control, and a delay"),
)


class _EffectTable(Mapping[str, EffectEntry]):
    """Built-in effects in their order, then those of plug-ins by name, imported as by a ``Registry``."""

    def __init__(self, entries: tuple[EffectEntry, ...]) -> None:
        self.built_in = {entry.key: entry for entry in entries}

    def __getitem__(self, key: str) -> EffectEntry:
        if key in self.built_in:
            return self.built_in[key]
        stage = SENSOR_STAGES[key]
        return EffectEntry(key, stage.title, stage.tip, plug_in=stage)

    def __iter__(self) -> Iterator[str]:
        yield from self.built_in
        yield from SENSOR_STAGES

    def __len__(self) -> int:
        return len(self.built_in) + len(SENSOR_STAGES)


EFFECTS = _EffectTable(_ENTRIES)
