"""By what a session runs at one instant: all that a person may change while it runs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from app.contacts.reading_settings import ReadingSettings, reading_from
from app.control.behaviour import Behaviour, behaviours_from
from app.control.command import ControlChanged, ControlSettings
from app.control.settings_check import settings_from
from app.maps.tactile_map import TactileMap
from app.scene.effects import Effects
from app.session.inputs import BehavioursChanged, EffectsChanged, MapEdited, ReadingChanged, SessionInput
from app.session.prepare import Prepared


@dataclass(frozen=True, eq=False)
class Rules:
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
    def of_scene(cls, prepared: Prepared) -> Rules:
        """As the scene says.

        Raises:
            TactileMapsError: It says what there is not.
        """
        scene = prepared.scene
        control, behaviours = settings_from(scene.control), behaviours_from(scene.behaviours)
        return cls(control, scene.effects, behaviours, reading_from(scene.reading), prepared.map)

    def after(self, act: SessionInput) -> Rules:
        """As they are once an input has taken effect; the same value where it is none of theirs."""
        if isinstance(act, ControlChanged):
            return replace(self, settings=act.settings)
        if isinstance(act, EffectsChanged):
            return replace(self, effects=act.effects)
        if isinstance(act, BehavioursChanged):
            return replace(self, behaviours=act.behaviours)
        if isinstance(act, ReadingChanged):
            return replace(self, reading=act.settings)
        return replace(self, map=act.map) if isinstance(act, MapEdited) else self

    def since(self, before: Rules) -> list[SessionInput]:
        """The inputs that lead here from other rules."""
        acts: list[SessionInput] = []
        if self.settings != before.settings:
            acts.append(ControlChanged(self.settings))
        if self.effects != before.effects:
            acts.append(EffectsChanged(self.effects))
        if self.behaviours != before.behaviours:
            acts.append(BehavioursChanged(self.behaviours))
        if self.reading != before.reading:
            acts.append(ReadingChanged(self.reading))
        if self.map is not before.map:
            acts.append(MapEdited("As it was edited before", self.map))
        return acts


def rules_at(start: Rules, inputs: Iterable[tuple[int, SessionInput]], tick: int) -> Rules:
    """The rules in force at a tick of a session.

    Args:
        start: Of its scene.
        inputs: With their ticks, rising.
        tick: Up to which they are heeded, itself included.
    """
    for at, act in inputs:
        if at > tick:
            break
        start = start.after(act)
    return start
