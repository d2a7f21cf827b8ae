"""The one question every contact model answers, and the models by name: what people call them, what to say of each, how
to build it.

Listed are those that need no physics engine. Each is imported when it is built, so that a scene with a cheap one does
not load what the others need.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.plugins import Plugin, PluginObject, Registry, guard_call
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNote
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load
from tactile_maps.tactile.mechanics.receptive_field import ReceptiveField, cell_field, disc_field
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects


class ContactModel(Protocol):
    """From loads to pressures. It may remember neighbourhoods, never results.

    Attributes:
        notes: What it had to do instead of what it promises at the last reading; empty when nothing.
    """

    notes: tuple[ContactNote, ...]

    def pressures(self, loads: Sequence[Load]) -> FloatArray:
        """(taxels,) mean pressure that each taxel feels [Pa]; loads add up."""


@dataclass(frozen=True)
class ContactModelEntry:
    """One contact model.

    Attributes:
        name: As in a scene file.
        title: For people.
        tip: What it knows and what it costs, in one sentence.
        build: From the skin, its cover and the sensor, whose electrodes decide what each taxel feels.
    """

    name: str
    title: str
    tip: str
    build: Callable[[Skin, ElasticLayer, SensorEffects], ContactModel]


def _point(skin: Skin, layer: ElasticLayer, sensor: SensorEffects) -> ContactModel:
    from tactile_maps.tactile.models.point import PointModel

    return PointModel(skin, field=_field(skin, sensor))


def _water_fill(skin: Skin, layer: ElasticLayer, sensor: SensorEffects) -> ContactModel:
    from tactile_maps.tactile.models.water_fill import WaterFillModel

    return WaterFillModel(skin, stiffness=layer.foundation, field=_field(skin, sensor))


def _punch(skin: Skin, layer: ElasticLayer, sensor: SensorEffects) -> ContactModel:
    from tactile_maps.tactile.models.punch import PunchModel

    return PunchModel(skin, layer=layer, field=_field(skin, sensor))


def _half_space(skin: Skin, layer: ElasticLayer, sensor: SensorEffects) -> ContactModel:
    from tactile_maps.tactile.models.half_space import HalfSpaceModel

    return HalfSpaceModel(skin, layer=layer, field=_field(skin, sensor))


def _field(skin: Skin, sensor: SensorEffects) -> ReceptiveField:
    """What a taxel feels: its pad if the sensor has pads, else its whole cell."""
    return cell_field(skin) if sensor.area_averaging is None else disc_field(skin, sensor.area_averaging.radius)


_ENTRIES = (
    ContactModelEntry(
        "point", "Point", "All force on the nearest taxel: cheapest, without pressure distribution.", _point
    ),
    ContactModelEntry(
        "water-fill",
        "Water-fill",
        "Winkler foundation (independent springs) under the body. Total force exact.",
        _water_fill,
    ),
    ContactModelEntry(
        "punch", "Punch", "Winkler foundation with tilt: total force and centre of pressure exact.", _punch
    ),
    ContactModelEntry(
        "half-space",
        "Half-space",
        "Water-fill with the elastic half-space's blur at the depth of the taxels.",
        _half_space,
    ),
)
IN_PHYSICS = ("foundation", "depth")
"""Models that the physics engine itself answers."""


def _guarded(plugin: Plugin, entry: ContactModelEntry) -> ContactModelEntry:
    """Return a plug-in's entry whose models return a finite pressure for each taxel or raise."""

    def build(
        make: Callable[[Skin, ElasticLayer, SensorEffects], object],
        skin: Skin,
        layer: ElasticLayer,
        sensor: SensorEffects,
    ) -> PluginObject:
        def pressures(method: Callable[[Sequence[Load]], object], loads: Sequence[Load]) -> FloatArray:
            found = np.array(method(loads), dtype=np.float64)
            if found.shape != (len(skin),) or not np.isfinite(found).all():
                raise plugin.error("it gave no finite pressure for each taxel", f"shape {found.shape}")
            return found

        return PluginObject(plugin, make(skin, layer, sensor), "notes", "pressures", checks={"pressures": pressures})

    return replace(entry, build=guard_call(plugin, entry.build, "skin", "layer", "sensor", check=build))


CONTACT_MODELS: Registry[ContactModelEntry] = Registry(
    "contact_models", ContactModelEntry, _ENTRIES, _guarded, reserved=(*IN_PHYSICS, "off", "auto")
)
"""By name, from the cheapest on; then those of plug-ins."""
