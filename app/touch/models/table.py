"""The contact models that need no physics engine, by name: what people call them, what to say of each, how to build it.

Each is imported when it is built, so that a scene with a cheap one does not load what the others need.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from app.skin.skin import Skin
from app.touch.layer import Layer
from app.touch.models.model import ContactModel
from app.touch.receptive_field import ReceptiveField, discs, whole_cells
from app.touch.sensor.effects import SensorEffects


@dataclass(frozen=True)
class ModelEntry:
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
    build: Callable[[Skin, Layer, SensorEffects], ContactModel]


def _point(skin: Skin, layer: Layer, sensor: SensorEffects) -> ContactModel:
    from app.touch.models.point import Point

    return Point(skin, field=_field(skin, sensor))


def _water_fill(skin: Skin, layer: Layer, sensor: SensorEffects) -> ContactModel:
    from app.touch.models.water_fill import WaterFill

    return WaterFill(skin, stiffness=layer.foundation, field=_field(skin, sensor))


def _punch(skin: Skin, layer: Layer, sensor: SensorEffects) -> ContactModel:
    from app.touch.models.punch import Punch

    return Punch(skin, layer=layer, field=_field(skin, sensor))


def _half_space(skin: Skin, layer: Layer, sensor: SensorEffects) -> ContactModel:
    from app.touch.models.half_space import HalfSpace

    return HalfSpace(skin, layer=layer, field=_field(skin, sensor))


def _field(skin: Skin, sensor: SensorEffects) -> ReceptiveField:
    """What a taxel feels: its pad if the sensor has pads, else its whole cell."""
    return whole_cells(skin) if sensor.area_averaging is None else discs(skin, sensor.area_averaging.radius)


_ENTRIES = (
    ModelEntry("point", "Point", "All force on the nearest taxel. For teaching: no shape, and the cheapest.", _point),
    ModelEntry("water-fill", "Water-fill", "The force spread under the body, as on a bed of springs. Exact in force.",
               _water_fill),
    ModelEntry("punch", "Punch", "As water-fill, tilted until the moment is right: the centre of pressure is exact.",
               _punch),
    ModelEntry("half-space", "Half-space", "Water-fill, felt through the depth of the cover, which blurs it.",
               _half_space),
)  # fmt: skip
MODELS: Mapping[str, ModelEntry] = MappingProxyType({entry.name: entry for entry in _ENTRIES})
"""By name, from the cheapest on."""
