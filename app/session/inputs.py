"""What a person may do to a running session."""

from __future__ import annotations

from dataclasses import dataclass

from app.control.command import ControlChanged
from app.maps.tactile_map import TactileMap
from app.simulation.poke import PokeInput, PokeMoved, PokePressed, PokeReleased


@dataclass(frozen=True, eq=False)
class MapEdited:
    """The map was edited: contacts are placed and controlled by this one from the next tick on.

    Attributes:
        name: Of the edit, for people.
        map: Of the same skin.
    """

    name: str
    map: TactileMap


SessionInput = PokeInput | ControlChanged | MapEdited

__all__ = ["ControlChanged", "MapEdited", "PokeMoved", "PokePressed", "PokeReleased", "SessionInput"]
