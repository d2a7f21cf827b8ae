"""What a person may do to a running session."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.behaviours import Behaviour, ControlTrigger
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.arrays import FloatArray, IntArray, freeze_arrays
from tactile_maps.core.codec import LATER
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.scene.effects import Effects
from tactile_maps.tactile.poke import PokeInput, PokeMoved, PokePressed, PokeReleased


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
        speed: How fast the rest posture goes there: its fastest joint [rad/s, or m/s]; None for at once.
    """

    posture: tuple[float, ...]
    speed: float | None = field(default=None, metadata=LATER)


@dataclass(frozen=True)
class PosturePlaced:
    """The robot stands still in this posture, which is also the one of rest, from the next tick on.

    Only where nothing touches it, before and after: it does not go there. A reset forgets it.

    Attributes:
        posture: Position of each joint, in the robot's order [rad, or m for a slide].
    """

    posture: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class CalibrationUsed:
    """What a real skin's values mean from the next tick on: pressure = gain (value - offset - baseline).

    Attributes:
        gain: (taxels,) pascals for each unit of the values.
        offset: (taxels,) value of the untouched taxel, in that unit.
        baseline: (taxels,) what a tare found above the offset, in that unit.
        spread: (taxels,) standard deviation in the tare, in that unit; None without one.
        known: Whether the gains were measured.
        mode: What is shown: ``raw``, above the ``baseline``, or ``kPa``.
        counts: (taxels,) number of readings of each taxel in the tare; None where it is not known.
        tail_scale: Factor of the noise's limits by the shape of its upper tail; see ``TailShape``.
        tail_heaviness: Reciprocal of the tail's degrees of freedom; 0 for a normal tail.
        broken: (k,) numbers of broken taxels, whose readings contacts are not read from; rising.
    """

    gain: FloatArray
    offset: FloatArray
    baseline: FloatArray
    spread: FloatArray | None
    known: bool
    mode: Literal["raw", "baseline", "kPa"]
    counts: IntArray | None = field(default=None, metadata=LATER)
    tail_scale: float = field(default=1.0, metadata=LATER)
    tail_heaviness: float = field(default=0.0, metadata=LATER)
    broken: IntArray = field(default_factory=lambda: np.zeros(0, np.int64), metadata=LATER)

    def __post_init__(self) -> None:
        freeze_arrays(self, "gain", "offset", "baseline", "spread")
        freeze_arrays(self, "counts", "broken", dtype=np.int64)


SessionInput = (
    PokeInput
    | ControlChanged
    | MapEdited
    | EffectsChanged
    | BehavioursChanged
    | ReadingChanged
    | RestChanged
    | PosturePlaced
    | CalibrationUsed
)


def remembered(session_input: SessionInput) -> SessionInput:
    """An input as a session keeps it: an edited map without what can be worked out again, so that an afternoon of moves
    takes kilobytes and not gigabytes.
    """
    if not isinstance(session_input, MapEdited):
        return session_input
    return MapEdited(session_input.name, session_input.map.without_caches())


__all__ = [
    "BehavioursChanged",
    "CalibrationUsed",
    "ControlChanged",
    "EffectsChanged",
    "MapEdited",
    "PokeMoved",
    "PokePressed",
    "PokeReleased",
    "PosturePlaced",
    "ReadingChanged",
    "RestChanged",
    "SessionInput",
    "remembered",
]
