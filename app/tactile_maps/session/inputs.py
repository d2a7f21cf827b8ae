"""Inputs of a running session."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.behaviours import Behaviour, ControlTrigger
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray
from tactile_maps.core.codec import LATER
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.scene.effects import Effects
from tactile_maps.tactile.poke import PokeInput, PokeMoved, PokePressed, PokePulled, PokeReleased


@dataclass(frozen=True)
class ControlChanged:
    """Change of the controller's settings; recorded like a poke.

    Attributes:
        settings: The new settings.
        by: The trigger; None for a change by the user. A session derives the changes that its behaviours cause, and
            ignores such inputs from outside.
    """

    settings: ControlSettings
    by: ControlTrigger | None = None


@dataclass(frozen=True, eq=False)
class MapEdited:
    """Edited map by which contacts are located and controlled from the next tick on.

    Attributes:
        name: Name of the edit for the user.
        map: Map of the same skin.
    """

    name: str
    map: TactileMap


@dataclass(frozen=True)
class EffectsChanged:
    """Effects to simulate from the next tick on; robot, objects and fingers keep their positions."""

    effects: Effects


@dataclass(frozen=True)
class BehavioursChanged:
    """Behaviours that contact events trigger from the next tick on, instead of the previous ones."""

    behaviours: tuple[Behaviour, ...]


@dataclass(frozen=True)
class ReadingChanged:
    """Settings of the contact detection from the next tick on; contacts keep their identifiers."""

    settings: ReadingSettings


@dataclass(frozen=True)
class RestChanged:
    """New rest posture from the next tick on, until a reset.

    Attributes:
        posture: Position of each joint, in the robot's order [rad, or m for a slide].
        speed: Speed of the fastest joint on the way to it [rad/s, or m/s]; None for an immediate change.
    """

    posture: tuple[float, ...]
    speed: float | None = field(default=None, metadata=LATER)


@dataclass(frozen=True)
class PosturePlaced:
    """Posture in which the robot is placed at the next tick, at rest; it also becomes the rest posture, until a reset.

    Nothing may touch the robot before and after, because it does not move there.

    Attributes:
        posture: Position of each joint, in the robot's order [rad, or m for a slide].
    """

    posture: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class CalibrationUsed(ArrayFields):
    """Calibration of a real skin from the next tick on: pressure = gain (value - offset - baseline), or gain times a
    curve of that change.

    Attributes:
        gain: (taxels,) pascals per unit of the values.
        offset: (taxels,) value of the untouched taxel, in that unit.
        baseline: (taxels,) result of the tare above the offset, in that unit.
        spread: (taxels,) standard deviation in the tare, in that unit; None without one.
        known: Whether the gains were measured.
        mode: Displayed values: ``raw``, above the ``baseline``, or ``kPa``.
        counts: (taxels,) number of readings of each taxel in the tare; None if unknown.
        tail_scale: Factor of the noise's limits by the shape of its upper tail; see ``TailShape``.
        tail_heaviness: Reciprocal of the tail's degrees of freedom; 0 for a normal tail.
        broken: (k,) numbers of broken taxels, whose readings the contact detection ignores; ascending.
        curve: (taxels, 2, k) curves of the taxels, see ``Calibration``; None if pressures are proportional.
        shear_baseline: (taxels, 2) result of the tare along t1 and t2, in that unit; None without one.
        matrix: (taxels, 3, 3) matrices of the taxels, see ``Calibration``; None if channels are independent.
        stuck: (k,) numbers of the broken taxels that are stuck; ascending. The other broken ones are dead.
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
    curve: FloatArray | None = field(default=None, metadata=LATER)
    shear_baseline: FloatArray | None = field(default=None, metadata=LATER)
    matrix: FloatArray | None = field(default=None, metadata=LATER)
    stuck: IntArray = field(default_factory=lambda: np.zeros(0, np.int64), metadata=LATER)


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
    """Return an input as a session logs it: an edited map without its caches, kilobytes instead of megabytes each."""
    if isinstance(session_input, MapEdited):
        return MapEdited(session_input.name, session_input.map.without_caches())
    return session_input


__all__ = [
    "BehavioursChanged",
    "CalibrationUsed",
    "ControlChanged",
    "EffectsChanged",
    "MapEdited",
    "PokeMoved",
    "PokePressed",
    "PokePulled",
    "PokeReleased",
    "PosturePlaced",
    "ReadingChanged",
    "RestChanged",
    "SessionInput",
    "remembered",
]
