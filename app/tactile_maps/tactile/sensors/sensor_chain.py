"""The sensor: from the pressure that taxels feel to what arrives from them; and the stages that plug-ins add."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.arrays import BoolArray, FloatArray, readonly
from tactile_maps.core.errors import SimulationError
from tactile_maps.core.plugins import Plugin, PluginObject, Registry, guard_call
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.sensors.sensor_effects import (
    SENSOR_KEYS,
    DeadTaxelsStage,
    PluginEffect,
    Readout,
    SaturationStage,
    SensorEffect,
    SensorEffects,
    SensorStage,
    check_range,
)

StageRead: TypeAlias = Callable[[FloatArray], FloatArray]

_MOST = 1e100
"""[Pa] No stage overflows below."""
_STAGES = tuple(key for key in SENSOR_KEYS if key != "area_averaging")
EFFECTS_OF_BODIES = (
    "dynamics", "fingers", "contact", "gravity", "friction", "joint_limits", "joint_friction", "skin",
    "time_averaging", "timestep", "integrator",
)  # fmt: skip
"""Keys of a scene's effects that are none of the sensor: no plug-in may have their names."""


@dataclass(frozen=True)
class StageOption:
    """A number that a scene may set of a plug-in's stage.

    Attributes:
        name: In scenes.
        usual: Where the scene sets none.
        low: The least that makes sense.
        high: The most.
    """

    name: str
    usual: float
    low: float
    high: float


@dataclass(frozen=True)
class SensorStageEntry:
    """A stage of the sensor that a plug-in adds; off until a scene or a person switches it on.

    Attributes:
        name: The key in a scene's effects.
        title: For people.
        tip: What it does, in a sentence without its full stop.
        build: The stage at work for a readout and its numbers by name.
        options: Of all numbers that ``build`` is given.
        before: The built-in effect, one of ``SENSOR_KEYS`` but ``area_averaging``, in front of which it stands in the
            signal.
        noise: Standard deviation [Pa] by which it makes a reading wrong, for its numbers by name: what counts as
            touched stands out of it, and error bars hold it. None where it makes readings no less certain.
    """

    name: str
    title: str
    tip: str
    build: Callable[[Readout, Mapping[str, float]], SensorStage]
    options: tuple[StageOption, ...] = ()
    before: str = "saturation"
    noise: Callable[[Mapping[str, float]], float] | None = None

    def effect(self, numbers: Mapping[str, float]) -> PluginEffect:
        """It is on with these numbers, the others as usual.

        Raises:
            SimulationError: A number is out of its range.
        """
        options = {option.name: numbers.get(option.name, option.usual) for option in self.options}
        for option in self.options:
            check_range(f"{self.name}.{option.name}", options[option.name], option.low, option.high)
        return PluginEffect(self.name, tuple(options.items()))


def _guarded(plugin: Plugin, entry: SensorStageEntry) -> SensorStageEntry:
    """Return a plug-in's entry whose stages return a finite reading for each taxel or raise."""
    if entry.before not in _STAGES:
        raise plugin.error(f"it stands before {entry.before}, which is none of {', '.join(_STAGES)}")

    def state(method: Callable[[], object]) -> FloatArray:
        return np.array(method(), dtype=np.float64).ravel()

    def build(make: Callable[..., object], readout: Readout, options: Mapping[str, float]) -> PluginObject:
        def read(method: Callable[[FloatArray], object], pressures: FloatArray) -> FloatArray:
            found = np.array(method(readonly(pressures)), dtype=np.float64)
            if found.shape != (len(readout.skin),) or not np.abs(found).max(initial=0.0) <= _MOST:
                raise plugin.error("it gave no finite reading for each taxel", f"shape {found.shape}")
            return found

        stage = make(readout, options)
        return PluginObject(plugin, stage, "read", "reset", "state", checks={"read": read, "state": state})

    def noise(function: Callable[..., float], options: Mapping[str, float]) -> float:
        found = float(function(options))
        if not 0.0 <= found <= _MOST:  # NaN compares false
            raise plugin.error("its noise is no standard deviation", f"{found} Pa")
        return found

    guarded_build = guard_call(plugin, entry.build, "readout", "options", check=build)
    with plugin.at_work():
        usual = entry.effect({})
    if entry.noise is None:
        return replace(entry, build=guarded_build, noise=lambda options: 0.0)
    guarded_noise = guard_call(plugin, entry.noise, "options", check=noise)
    guarded_noise(dict(usual.options))
    return replace(entry, build=guarded_build, noise=guarded_noise)


def plugin_noise(effects: SensorEffects) -> float:
    """Standard deviation [Pa] of a reading by all stages of plug-ins that are on; they know nothing of each other."""
    found = (SENSOR_STAGES[effect.name].noise for effect in effects.plug_ins)
    numbers = (dict(effect.options) for effect in effects.plug_ins)
    return math.hypot(*(noise(options) for noise, options in zip(found, numbers, strict=True) if noise is not None))


SENSOR_STAGES: Registry[SensorStageEntry] = Registry(
    "sensor_stages", SensorStageEntry, (), _guarded, reserved=(*SENSOR_KEYS, *EFFECTS_OF_BODIES, "auto")
)
"""Those of plug-ins, by name; the built-in effects are the fields of ``SensorEffects``."""


class SensorChain:
    """The effects that are on, one after the other, once a tick. Mutable: some remember.

    Cost at 1,000 taxels: 37 µs with all on, 1.9 µs with none, for looking whether all pressures are numbers.

    Args:
        skin: Whose taxels.
        effects: Which are on; area averaging is no stage but a receptive field of the contact model.
        tick: From one reading to the next [s].
        seed: Of all random numbers, >= 0; every effect draws its own.

    Raises:
        SimulationError: Tick or seed is no such number.
    """

    def __init__(self, skin: Skin, effects: SensorEffects, *, tick: float, seed: int) -> None:
        self._readout = Readout(skin, tick, seed)
        self._effects = SensorEffects()
        self._stages: dict[str, SensorStage] = {}
        self.use(effects)

    @property
    def effects(self) -> SensorEffects:
        """Which are on."""
        return self._effects

    def use(self, effects: SensorEffects, *, averages: bool = False) -> None:
        """Change what is on; an effect that was on with the same numbers goes on from where it is.

        Args:
            effects: Which are on.
            averages: Whether a sample is the mean since the one before.
        """
        stages: dict[str, SensorStage] = {}
        changed = averages != self._readout.averages
        self._readout = replace(self._readout, averages=averages)
        for name in _order(effects):
            wanted = effects.of(name)
            if wanted is not None:
                same = wanted == self._effects.of(name) and not (changed and name == "sampling")
                stages[name] = self._stages[name] if same else self._built(wanted)
        self._effects = effects
        self._stages = stages

    def _built(self, wanted: SensorEffect | PluginEffect) -> SensorStage:
        if isinstance(wanted, PluginEffect):
            return SENSOR_STAGES[wanted.name].build(self._readout, dict(wanted.options))
        return wanted.stage(self._readout)

    @property
    def stages(self) -> tuple[tuple[str, StageRead], ...]:
        """Field names of the effects that are on and what each does, in the order of the signal; to be called in turn.

        The first also refuses pressures that are no numbers, as ``read`` does.
        """
        calls: list[tuple[str, StageRead]] = [(name, stage.read) for name, stage in self._stages.items()]
        if calls:
            name, first = calls[0]
            calls[0] = (name, partial(self._enter, first))
        return tuple(calls)

    def read(self, pressures: FloatArray) -> FloatArray:
        """What arrives from the taxels for what they feel, one tick after the last call.

        Args:
            pressures: (taxels,) [Pa]; not changed.

        Returns:
            (taxels,) [Pa], possibly negative where there is noise or drift and no threshold.

        Raises:
            SimulationError: A pressure is no number that means something; nothing was read then.
        """
        self._check(pressures)
        for stage in self._stages.values():
            pressures = stage.read(pressures)
        return pressures

    def reset(self) -> None:
        """Back to before the first reading; the same readings follow."""
        for stage in self._stages.values():
            stage.reset()

    def state(self) -> FloatArray:
        """(k,) all that changes from reading to reading; with skin, effects, tick and seed it determines the future."""
        return np.concatenate([np.zeros(0), *(stage.state() for stage in self._stages.values())])

    @property
    def dead(self) -> NDArray[np.int8]:
        """(taxels,) 0 alive, 1 dead, 2 stuck."""
        stage = self._stages.get("dead_taxels")
        if isinstance(stage, DeadTaxelsStage):
            return stage.codes
        return readonly(np.zeros(len(self._readout.skin)), np.int8)

    @property
    def saturated(self) -> BoolArray:
        """(taxels,) which of those alive stood at their highest reading when last read.

        As the amplifier knows it, at once: the bus's rate and delay do not count here.
        """
        stage = self._stages.get("saturation")
        if isinstance(stage, SaturationStage):
            return stage.saturated & (self.dead == 0)
        return np.zeros(len(self._readout.skin), dtype=bool)

    def _enter(self, first: StageRead, pressures: FloatArray) -> FloatArray:
        self._check(pressures)
        return first(pressures)

    def _check(self, pressures: FloatArray) -> None:
        skin = self._readout.skin
        if pressures.shape != (len(skin),):
            raise SimulationError("these are not the taxels' pressures", place=f"{len(skin)} taxels",
                                  value=f"{pressures.shape} numbers")  # fmt: skip
        if np.abs(pressures).max(initial=0.0) <= _MOST:  # false for NaN too
            return
        taxel = int(np.flatnonzero(~(np.abs(pressures) <= _MOST))[0])
        patch = skin.patches[int(skin.patch_of[taxel])]
        raise SimulationError("the pressure is not finite", place=f"taxel {taxel} on {patch.name}",
                              value=f"{pressures[taxel]} Pa")  # fmt: skip


def _order(effects: SensorEffects) -> tuple[str, ...]:
    """Names of all stages in the order of the signal; those of plug-ins before the one their entry names."""
    if not effects.plug_ins:
        return _STAGES
    before = {effect.name: SENSOR_STAGES[effect.name].before for effect in effects.plug_ins}
    return tuple(name for key in _STAGES for name in (*(one for one in before if before[one] == key), key))
