"""The settings by which a session runs at one instant: all that a person may change while it runs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

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


@dataclass(frozen=True, eq=False)
class RuntimeSettings:
    """A person's choices in force.

    Attributes:
        settings: Of the controller.
        effects: What is simulated.
        behaviours: What contact events trigger.
        reading: How contacts are read.
        map: By which they are placed and controlled.
    """

    settings: ControlSettings
    effects: Effects
    behaviours: tuple[Behaviour, ...]
    reading: ReadingSettings
    map: TactileMap

    @classmethod
    def of_scene(cls, prepared: PreparedScene) -> RuntimeSettings:
        """As the scene says.

        Raises:
            TactileMapsError: It says what there is not.
        """
        scene = prepared.scene
        control = settings_from(scene.control)
        behaviours = behaviours_from(scene.behaviours)
        return cls(control, scene.effects, behaviours, reading_from(scene.reading), prepared.map)

    def after(self, session_input: SessionInput) -> RuntimeSettings:
        """As they are once an input has taken effect; the same value where it is none of theirs."""
        if isinstance(session_input, ControlChanged):
            return replace(self, settings=session_input.settings)
        if isinstance(session_input, EffectsChanged):
            return replace(self, effects=session_input.effects)
        if isinstance(session_input, BehavioursChanged):
            return replace(self, behaviours=session_input.behaviours)
        if isinstance(session_input, ReadingChanged):
            return replace(self, reading=session_input.settings)
        return replace(self, map=session_input.map) if isinstance(session_input, MapEdited) else self

    def since(self, before: RuntimeSettings) -> list[SessionInput]:
        """The inputs that lead here from other settings."""
        inputs: list[SessionInput] = []
        if self.settings != before.settings:
            inputs.append(ControlChanged(self.settings))
        if self.effects != before.effects:
            inputs.append(EffectsChanged(self.effects))
        if self.behaviours != before.behaviours:
            inputs.append(BehavioursChanged(self.behaviours))
        if self.reading != before.reading:
            inputs.append(ReadingChanged(self.reading))
        if self.map is not before.map:
            inputs.append(MapEdited("As it was edited before", self.map))
        return inputs


CHANGES = (ControlChanged, EffectsChanged, BehavioursChanged, ReadingChanged, MapEdited)
"""The inputs that ``RuntimeSettings.after`` heeds; the others, a finger's moves most of all, change nothing of it."""


def runtime_settings_at(
    start: RuntimeSettings, inputs: Iterable[tuple[int, SessionInput]], tick: int
) -> RuntimeSettings:
    """The settings in force at a tick of a session.

    Args:
        start: Of its scene.
        inputs: With their ticks, rising.
        tick: Up to which they are heeded, itself included.
    """
    for at, session_input in inputs:
        if at > tick:
            break
        start = start.after(session_input)
    return start
