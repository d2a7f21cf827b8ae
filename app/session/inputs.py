"""What a person may do to a running session."""

from __future__ import annotations

from dataclasses import dataclass

from app.contacts.pipeline import ReadingSettings
from app.control.behaviours import Behaviour, ControlTrigger
from app.control.command import ControlSettings
from app.maps.tactile_map import TactileMap
from app.scene.effects import Effects
from app.tactile.poke import PokeInput, PokeMoved, PokePressed, PokeReleased


@dataclass(frozen=True)
class ControlChanged:
    """The controller's settings changed; an input, recorded like a poke.

    Attributes:
        settings: From now on.
        by: What triggered it; None where a person did it. A session derives what its behaviours do again, and takes no
            such input from outside.
    """

    settings: ControlSettings
    by: ControlTrigger | None = None


@dataclass(frozen=True, eq=False)
class MapEdited:
    """The map was edited: contacts are placed and controlled by this one from the next tick on.

    Attributes:
        name: Of the edit, for people.
        map: Of the same skin.
    """

    name: str
    map: TactileMap


@dataclass(frozen=True)
class EffectsChanged:
    """Other effects are simulated from the next tick on; the robot, the objects and the fingers stay where they are."""

    effects: Effects


@dataclass(frozen=True)
class BehavioursChanged:
    """Contact events trigger these from the next tick on, and no others."""

    behaviours: tuple[Behaviour, ...]


@dataclass(frozen=True)
class ReadingChanged:
    """Contacts are read otherwise from the next tick on; who they are stays."""

    settings: ReadingSettings


@dataclass(frozen=True)
class RestChanged:
    """Another rest posture from the next tick on, as one who drives the joints wants it; a reset forgets it.

    Attributes:
        posture: Position of each joint, in the robot's order [rad, or m for a slide].
    """

    posture: tuple[float, ...]


SessionInput = (
    PokeInput | ControlChanged | MapEdited | EffectsChanged | BehavioursChanged | ReadingChanged | RestChanged
)

__all__ = [
    "BehavioursChanged",
    "ControlChanged",
    "EffectsChanged",
    "MapEdited",
    "PokeMoved",
    "PokePressed",
    "PokeReleased",
    "ReadingChanged",
    "RestChanged",
    "SessionInput",
]
