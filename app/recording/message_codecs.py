"""Inputs, contact events and failures as JSON messages, which any program that reads MCAP can read; the list of topics.

Input: {"tick": n, "kind": name, ...fields}. The kind "effects" has all effects, by name; one of the sensor is an object
of its options, or null where it is off; they are read field by field and strictly, since what stands in a recording was
written by anyone. The kind "edit" has the edit's name and, in base64, how the map differs from the recording's.

Contact event: {"tick": n, "time": s, "kind": "press", "phase": "ended", "contacts": [ids], "links": [names],
"at": place, "to": place or null, "force": N, "duration": s, "travelled": m, "words": "press on forearm, 4.2 N, 0.8 s"}.
A place is {"patch": n, "face": n, "weights": [3 numbers]}.

Failure, why a session stopped by itself: {"tick": n, "problem": text, "place": text, "value": text, "remedy": text},
the last three null where there is none.

Floats are written so that they read back equal. Frames have a codec of their own, ``frame_codec``.
"""

from __future__ import annotations

import base64
import json
import math
from dataclasses import asdict, fields, is_dataclass
from types import NoneType
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from app.contacts.events import EVENT_KINDS, ContactEvent
from app.contacts.pipeline import ReadingSettings
from app.control.behaviours import Behaviour
from app.control.command import ControlChanged, ControlSettings
from app.core.errors import RecordingError, SimulationError, TactileMapsError
from app.geometry.mesh import SurfacePoint
from app.maps.formats.map_file import edit_from_bytes, edit_to_bytes
from app.maps.tactile_map import TactileMap
from app.recording.frame_codec import FRAME_SCHEMA
from app.scene.effects import Effects
from app.session.inputs import BehavioursChanged, EffectsChanged, MapEdited, ReadingChanged, SessionInput
from app.skin.skin import Skin
from app.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased

Value = TypeVar("Value")


def effects_to_json(effects: Effects) -> dict[str, Any]:
    """Every field by its name; an effect of the sensor is an object of its options, or null where it is off."""
    return asdict(effects)


def effects_from_json(raw: object) -> Effects:
    """The effects of ``effects_to_json``, equal to the last bit.

    Raises:
        ValueError: A field is missing, unknown or of another kind, or a word is none of those allowed.
        SimulationError: An option of the sensor is out of its range.
    """
    return _dataclass_from_json(Effects, raw, "effects")


def _dataclass_from_json(kind: type[Value], raw: object, place: str) -> Value:
    """A frozen dataclass from an object that names exactly its fields."""
    names = {field.name for field in fields(kind)}  # type: ignore[arg-type]
    if not isinstance(raw, dict) or raw.keys() != names:
        raise ValueError(f"{place} are not the fields {', '.join(sorted(names))}")
    hints = get_type_hints(kind)
    return kind(**{name: _value_from_json(hints[name], value, f"{place}.{name}") for name, value in raw.items()})


def _value_from_json(hint: Any, value: object, place: str) -> object:
    if get_origin(hint) is Literal:
        sound = value in get_args(hint)
    elif NoneType in get_args(hint):
        (kind,) = (option for option in get_args(hint) if option is not NoneType)
        return None if value is None else _dataclass_from_json(kind, value, place)
    elif is_dataclass(hint):
        return _dataclass_from_json(hint, value, place)  # type: ignore[arg-type]
    elif hint is float and type(value) in (int, float):
        value = float(value)  # type: ignore[arg-type]
        sound = math.isfinite(value)
    else:
        sound = type(value) is hint
    if not sound:
        raise ValueError(f"{place} cannot be {value!r}")
    return value


_INPUT_KINDS = {
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
        "properties": {"tick": {"type": "integer"}, "kind": {"enum": sorted([*_INPUT_KINDS, "edit", "effects"])}},
    }
)


def encode_input(tick: int, session_input: SessionInput, base: TactileMap) -> bytes:
    """One input as a message; ``base``: the recording's own map. Cost: 20 µs; an edit's as ``edit_to_bytes``.

    Raises:
        RecordingError: The map is of a skin whose taxels are believed to lie elsewhere than the recording's.
    """
    if isinstance(session_input, MapEdited):
        if not _same_places(session_input.map.skin, base.skin):
            remedy = "Record with a map of the skin that is simulated"
            raise RecordingError("a recording cannot hold a skin that is believed to lie elsewhere", remedy=remedy)
        packed = base64.b64encode(edit_to_bytes(session_input.map, base)).decode()
        return json.dumps({"tick": tick, "kind": "edit", "name": session_input.name, "map": packed}).encode()
    if isinstance(session_input, EffectsChanged):
        return json.dumps({"tick": tick, "kind": "effects", "effects": effects_to_json(session_input.effects)}).encode()
    kind = next(name for name, known in _INPUT_KINDS.items() if isinstance(session_input, known))
    return json.dumps({"tick": tick, "kind": kind, **asdict(session_input)}).encode()


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
        return tick, _INPUT_KINDS[kind](**raw)
    except (ValueError, KeyError, TypeError, AttributeError, TactileMapsError) as error:
        raise RecordingError("an input of the recording is damaged", value=error) from error


_PLACE_SCHEMA = {
    "type": "object",
    "required": ["patch", "face", "weights"],
    "properties": {
        "patch": {"type": "integer"},
        "face": {"type": "integer"},
        "weights": {"type": "array", "items": {"type": "number"}},
    },
}
_EVENT_PROPERTIES: dict[str, Any] = {
    "tick": {"type": "integer"},
    "time": {"type": "number"},
    "kind": {"enum": list(EVENT_KINDS)},
    "phase": {"enum": ["began", "ended"]},
    "contacts": {"type": "array", "items": {"type": "integer"}},
    "links": {"type": "array", "items": {"type": "string"}},
    "at": _PLACE_SCHEMA,
    "to": {"oneOf": [_PLACE_SCHEMA, {"type": "null"}]},
    "force": {"type": "number"},
    "duration": {"type": "number"},
    "travelled": {"type": "number"},
    "words": {"type": "string"},
}
EVENT_SCHEMA = json.dumps(
    {
        "title": "tactile_maps.ContactEvent",
        "description": __doc__,
        "type": "object",
        "required": list(_EVENT_PROPERTIES),
        "properties": _EVENT_PROPERTIES,
    }
)


def encode_event(event: ContactEvent) -> bytes:
    """One event as a message. Cost: 30 µs."""
    return json.dumps(asdict(event) | {"words": event.words}, ensure_ascii=False).encode()


def decode_event(data: bytes) -> ContactEvent:
    """The event of a message.

    Raises:
        RecordingError: The message is no contact event.
    """
    try:
        raw = json.loads(data)
        kind, phase = raw["kind"], raw["phase"]
        if kind not in EVENT_KINDS or phase not in ("began", "ended"):
            raise ValueError(f"{kind} {phase}")
        return ContactEvent(
            tick=int(raw["tick"]),
            time=float(raw["time"]),
            kind=kind,
            phase=phase,
            contacts=tuple(map(int, raw["contacts"])),
            links=tuple(map(str, raw["links"])),
            at=_place_from_json(raw["at"]),
            to=None if raw["to"] is None else _place_from_json(raw["to"]),
            force=float(raw["force"]),
            duration=float(raw["duration"]),
            travelled=float(raw["travelled"]),
        )
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise RecordingError("a contact event of the recording is damaged", value=error) from error


def _place_from_json(raw: Any) -> SurfacePoint:
    a, b, c = (float(weight) for weight in raw["weights"])
    return SurfacePoint(int(raw["patch"]), int(raw["face"]), (a, b, c))


_FAILURE_FIELDS = ("place", "value", "remedy")
FAILURE_SCHEMA = json.dumps(
    {
        "title": "tactile_maps.Failure",
        "type": "object",
        "required": ["tick", "problem", *_FAILURE_FIELDS],
        "properties": {"tick": {"type": "integer"}, "problem": {"type": "string"}},
    }
)


def encode_failure(tick: int, error: SimulationError) -> bytes:
    """Why a session stopped at ``tick``, as a message."""
    reasons = {name: None if getattr(error, name) is None else str(getattr(error, name)) for name in _FAILURE_FIELDS}
    return json.dumps({"tick": tick, "problem": error.problem, **reasons}).encode()


def decode_failure(data: bytes) -> tuple[int, SimulationError]:
    """Tick and error of a message; the error reads as it did.

    Raises:
        RecordingError: The message is no failure.
    """
    try:
        raw = json.loads(data)
        reasons = {name: None if raw[name] is None else str(raw[name]) for name in _FAILURE_FIELDS}
        return int(raw["tick"]), SimulationError(str(raw["problem"]), **reasons)
    except (ValueError, KeyError, TypeError) as error:
        raise RecordingError("the failure that ended the recording is damaged", value=error) from error


TOPICS = {
    "/frame": ("tactile_maps.Frame", FRAME_SCHEMA, "tactile_maps.Frame"),
    "/input": ("tactile_maps.Input", INPUT_SCHEMA, "json"),
    "/failure": ("tactile_maps.Failure", FAILURE_SCHEMA, "json"),
    "/event": ("tactile_maps.ContactEvent", EVENT_SCHEMA, "json"),
}
"""By topic: schema's name and text, and the encoding of a message."""
