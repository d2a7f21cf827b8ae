"""What a person may do to a running session."""

from __future__ import annotations

from app.control.command import ControlChanged
from app.simulation.poke import PokeInput, PokeMoved, PokePressed, PokeReleased

SessionInput = PokeInput | ControlChanged

__all__ = ["ControlChanged", "PokeMoved", "PokePressed", "PokeReleased", "SessionInput"]
