"""Settings of a session at one instant: everything that the user can change while it runs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from tactile_maps.contacts.pipeline import ReadingSettings, reading_from
from tactile_maps.control.behaviours import Behaviour, behaviours_from
from tactile_maps.control.controller_registry import settings_from
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.scene.effects import Effects
from tactile_maps.session.inputs import (
    BehavioursChanged,
    ControlChanged,
    EffectsChanged,
    MapEdited,
    ReadingChanged,
    SessionInput,
)
from tactile_maps.session.prepare import PreparedScene

_CHANGED: dict[type, tuple[str, str]] = {
    ControlChanged: ("settings", "settings"),
    EffectsChanged: ("effects", "effects"),
    BehavioursChanged: ("behaviours", "behaviours"),
    ReadingChanged: ("reading", "settings"),
    MapEdited: ("map", "map"),
}
"""Attribute of ``RuntimeSettings`` that an input sets, and the attribute of the input with its value."""
CHANGES = tuple(_CHANGED)
"""Inputs that change ``RuntimeSettings``; the others, above all the moves of fingers, do not."""


@dataclass(frozen=True, eq=False)
class RuntimeSettings:
    """The current choices of the user.

    Attributes:
        settings: Settings of the controller.
        effects: Simulated effects.
        behaviours: Reactions to contact events.
        reading: Settings of the contact detection.
        map: Map by which contacts are located and controlled.
    """

    settings: ControlSettings
    effects: Effects
    behaviours: tuple[Behaviour, ...]
    reading: ReadingSettings
    map: TactileMap

    @classmethod
    def of_scene(cls, prepared: PreparedScene) -> RuntimeSettings:
        """Return the settings that a scene states.

        Raises:
            TactileMapsError: The scene states an unknown or invalid setting.
        """
        scene = prepared.scene
        control = settings_from(scene.control)
        behaviours = behaviours_from(scene.behaviours)
        return cls(control, scene.effects, behaviours, reading_from(scene.reading), prepared.map)

    def after(self, session_input: SessionInput) -> RuntimeSettings:
        """Return the settings once an input has taken effect; the same object if the input does not change them."""
        if not isinstance(session_input, CHANGES):
            return self
        name, value = _CHANGED[type(session_input)]
        changed: dict[str, Any] = {name: getattr(session_input, value)}
        return replace(self, **changed)

    def since(self, before: RuntimeSettings) -> list[SessionInput]:
        """Return the inputs that lead from other settings to these."""
        named: dict[type, dict[str, str]] = {MapEdited: {"name": "Earlier edits"}}
        return [
            kind(**named.get(kind, {}), **{value: getattr(self, name)})
            for kind, (name, value) in _CHANGED.items()
            if getattr(self, name) != getattr(before, name)
        ]


def runtime_settings_at(
    start: RuntimeSettings, inputs: Iterable[tuple[int, SessionInput]], tick: int
) -> RuntimeSettings:
    """Return the settings at a tick of a session.

    Args:
        start: The settings of its scene.
        inputs: The inputs with their ticks, in ascending order.
        tick: The last tick whose inputs count.
    """
    for at, session_input in inputs:
        if at > tick:
            break
        start = start.after(session_input)
    return start
