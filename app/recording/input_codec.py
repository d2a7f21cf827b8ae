"""Inputs as JSON messages: {"tick": n, "kind": name, ...fields}; floats are written so that they read back equal.

The kind "effects" has all effects, by name; one of the sensor is an object of its options, or null where it is off. The
kind "edit" has the edit's name and, in base64, how the map differs from the recording's; see ``map_edit_file``.
"""

from __future__ import annotations

import base64
import json
from dataclasses import asdict

import numpy as np

from app.contacts.reading_settings import ReadingSettings
from app.control.behaviour import Behaviour
from app.control.command import ControlChanged, ControlSettings
from app.errors import RecordingError, TactileMapsError
from app.geometry.surface_point import SurfacePoint
from app.maps.map_edit_file import edit_from_bytes, edit_to_bytes
from app.maps.tactile_map import TactileMap
from app.recording.effects_codec import effects_from_json, effects_to_json
from app.session.inputs import (
    BehavioursChanged,
    EffectsChanged,
    MapEdited,
    PokeMoved,
    PokePressed,
    PokeReleased,
    ReadingChanged,
    SessionInput,
)
from app.skin.skin import Skin
from app.touch.poke import Finger

_KINDS = {
    "press": PokePressed,
    "move": PokeMoved,
    "release": PokeReleased,
    "control": ControlChanged,
    "behaviours": BehavioursChanged,
    "reading": ReadingChanged,
}

INPUT_SCHEMA = json.dumps(
    {
        "title": "tactile_maps.Input",
        "type": "object",
        "required": ["tick", "kind"],
        "properties": {"tick": {"type": "integer"}, "kind": {"enum": sorted([*_KINDS, "edit", "effects"])}},
    }
)


def encode_input(tick: int, act: SessionInput, base: TactileMap) -> bytes:
    """One input as a message; ``base``: the recording's own map. Cost: 20 µs; an edit's as ``edit_to_bytes``.

    Raises:
        RecordingError: The map is of a skin whose taxels are believed to lie elsewhere than the recording's.
    """
    if isinstance(act, MapEdited):
        if not _same_places(act.map.skin, base.skin):
            remedy = "Record with a map of the skin that is simulated"
            raise RecordingError("a recording cannot hold a skin that is believed to lie elsewhere", remedy=remedy)
        packed = base64.b64encode(edit_to_bytes(act.map, base)).decode()
        return json.dumps({"tick": tick, "kind": "edit", "name": act.name, "map": packed}).encode()
    if isinstance(act, EffectsChanged):
        return json.dumps({"tick": tick, "kind": "effects", "effects": effects_to_json(act.effects)}).encode()
    kind = next(name for name, known in _KINDS.items() if isinstance(act, known))
    return json.dumps({"tick": tick, "kind": kind, **asdict(act)}).encode()


def _same_places(one: Skin, other: Skin) -> bool:
    """Whether two skins, of the same taxels, have them in the same places."""
    pairs = zip(one.patches, other.patches, strict=True)
    return one is other or all(np.array_equal(a.taxels.positions, b.taxels.positions) for a, b in pairs)


def decode_input(data: bytes, base: TactileMap) -> tuple[int, SessionInput]:
    """Tick and input of a message; ``base``: the recording's own map.

    Raises:
        RecordingError: The message is no known input.
    """
    try:
        raw = json.loads(data)
        tick, kind = int(raw.pop("tick")), raw.pop("kind")
        if kind == "edit":
            return tick, MapEdited(str(raw["name"]), edit_from_bytes(base64.b64decode(raw["map"]), base))
        if kind == "effects":
            return tick, EffectsChanged(effects_from_json(raw["effects"]))
        if "at" in raw:
            at = raw["at"]
            a, b, c = (float(weight) for weight in at["weights"])
            raw["at"] = SurfacePoint(int(at["patch"]), int(at["face"]), (a, b, c))
        if kind == "press":
            raw["finger"] = Finger(**{key: float(value) for key, value in raw["finger"].items()})
        if kind == "control":
            raw["settings"] = ControlSettings(**raw["settings"])
        if kind == "reading":
            raw["settings"] = ReadingSettings(**raw["settings"])
        if kind == "behaviours":
            raw["behaviours"] = tuple(Behaviour(**behaviour) for behaviour in raw["behaviours"])
        return tick, _KINDS[kind](**raw)
    except (ValueError, KeyError, TypeError, AttributeError, TactileMapsError) as error:
        raise RecordingError("an input of the recording is damaged", value=error) from error
