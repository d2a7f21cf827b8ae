"""Protocol of contact models, and the registry of those that need no physics engine.

Each model is imported when it is built, so that scenes with a simple model load quickly.
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
    """Function from loads to pressures. It may cache neighbourhoods, but not results.

    Attributes:
        notes: Deviations at the last reading.
    """

    notes: tuple[ContactNote, ...]

    def pressures(self, loads: Sequence[Load]) -> FloatArray:
        """Return the mean pressure on each taxel (taxels,) [Pa]; loads add up."""


@dataclass(frozen=True)
class ContactModelEntry:
    """Entry of a contact model in the registry.

    Attributes:
        name: Name in scene files.
        title: Displayed name.
        tip: Principle and cost, in one sentence.
        build: Builds it from the skin, its cover and the sensor, whose pads determine the receptive fields.
    """

    name: str
    title: str
    tip: str
    build: Callable[[Skin, ElasticLayer, SensorEffects], ContactModel]


def _point(skin: Skin, layer: ElasticLayer, sensor: SensorEffects) -> ContactModel:
    from tactile_maps.tactile.models.point import PointModel

    return PointModel(skin, field=receptive_field(skin, sensor))


def _water_fill(skin: Skin, layer: ElasticLayer, sensor: SensorEffects) -> ContactModel:
    from tactile_maps.tactile.models.water_fill import WaterFillModel

    return WaterFillModel(skin, layer=layer, field=receptive_field(skin, sensor))


def _punch(skin: Skin, layer: ElasticLayer, sensor: SensorEffects) -> ContactModel:
    from tactile_maps.tactile.models.punch import PunchModel

    return PunchModel(skin, layer=layer, field=receptive_field(skin, sensor))


def _half_space(skin: Skin, layer: ElasticLayer, sensor: SensorEffects) -> ContactModel:
    from tactile_maps.tactile.models.half_space import HalfSpaceModel

    return HalfSpaceModel(skin, layer=layer, field=receptive_field(skin, sensor))


def receptive_field(skin: Skin, sensor: SensorEffects) -> ReceptiveField:
    """Return the receptive fields: pads if the sensor has pads, otherwise whole cells."""
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
"""Models that need the physics engine."""
WITH_SHEAR = ("point", "water-fill", "punch")
"""Models that distribute the friction of a load; in the foundation nothing rubs, and the others lose it."""


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
                raise plugin.error("it did not return a finite pressure for each taxel", f"shape {found.shape}")
            return found

        return PluginObject(plugin, make(skin, layer, sensor), "notes", "pressures", checks={"pressures": pressures})

    return replace(entry, build=guard_call(plugin, entry.build, "skin", "layer", "sensor", check=build))


CONTACT_MODELS: Registry[ContactModelEntry] = Registry(
    "contact_models", ContactModelEntry, _ENTRIES, _guarded, reserved=(*IN_PHYSICS, "off", "auto")
)
"""Contact models by name, the fastest first, then those of plug-ins."""
