"""Inputs, contact events, marks and failures as JSON messages, readable by all that reads MCAP; the list of topics.

Each message is one of the dataclasses here. ``tactile_maps.core.codec`` writes them, reads them strictly and makes
their schemas. Frames have a codec of their own, ``frame_codec``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, NamedTuple, TypeAlias

from tactile_maps.contacts.events import ContactEvent
from tactile_maps.core.codec import dump_json, json_schema, load_json
from tactile_maps.core.errors import RecordingError, SimulationError, TactileMapsError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.formats.map_file import edit_from_bytes, edit_to_bytes
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.recording.encoding.annotations import Mark
from tactile_maps.recording.encoding.frame_codec import FRAME_SCHEMA, check_place
from tactile_maps.session.bundle import DAMAGED
from tactile_maps.session.inputs import (
    BehavioursChanged,
    CalibrationUsed,
    ControlChanged,
    EffectsChanged,
    MapEdited,
    PosturePlaced,
    ReadingChanged,
    RestChanged,
    SessionInput,
)
from tactile_maps.skin.model.skin import Skin, same_triangles
from tactile_maps.tactile.poke import PokeInput, PokeMoved, PokePressed


@dataclass(frozen=True)
class MapEdit:
    """``MapEdited`` without what the recording holds already.

    Attributes:
        name: Of the edit, for people.
        map: How the map differs from the recording's, see ``edit_to_bytes``.
    """

    name: str
    map: bytes


RecordedInput: TypeAlias = (
    PokeInput
    | ControlChanged
    | BehavioursChanged
    | EffectsChanged
    | ReadingChanged
    | RestChanged
    | PosturePlaced
    | CalibrationUsed
    | MapEdit
)


@dataclass(frozen=True)
class InputMessage:
    """An input and the tick of the first frame that shows it."""

    tick: int
    input: RecordedInput


@dataclass(frozen=True)
class EventMessage:
    """A contact event, and the same in words for whoever reads the file."""

    event: ContactEvent
    words: str


@dataclass(frozen=True)
class FailureMessage:
    """Why a session stopped by itself: the tick that was not finished, and the parts of the error as it reads."""

    tick: int
    error: Literal["SimulationError"]
    problem: str
    place: str | None
    value: str | None
    remedy: str | None


def encode_input(tick: int, session_input: SessionInput, base: TactileMap) -> bytes:
    """One input as a message; ``base``: the recording's own map. Cost: 20 µs; an edit's as ``edit_to_bytes``.

    Raises:
        RecordingError: The map is of a skin with other triangles than the recording's: those of a map that was learned,
            between taxels. Places of the one skin are none of the other, so no frame could be read with it.
    """
    if not isinstance(session_input, MapEdited):
        return dump_json(InputMessage(tick, session_input))
    if not all(map(same_triangles, session_input.map.skin.patches, base.skin.patches)):
        remedy = "Record with a map of the skin that is simulated"
        raise RecordingError("a recording cannot store a map whose triangles are not the skin's", remedy=remedy)
    return dump_json(InputMessage(tick, MapEdit(session_input.name, edit_to_bytes(session_input.map, base))))


def _check_calibration(found: CalibrationUsed, taxels: int, file: str | None) -> None:
    for name in ("gain", "offset", "baseline", "spread"):
        values = getattr(found, name)
        if values is not None and values.shape != (taxels,):
            problem = "a calibration is not of this skin"
            raise RecordingError(problem, file=file, place=f"/input: input.{name}", value=values.shape, remedy=DAMAGED)
    if found.broken.ndim != 1 or not ((found.broken >= 0) & (found.broken < taxels)).all():
        problem = "a broken taxel is not of this skin"
        raise RecordingError(problem, file=file, place="/input: input.broken", value=found.broken, remedy=DAMAGED)


def decode_input(data: bytes, base: TactileMap, *, file: str | None = None) -> tuple[int, SessionInput]:
    """Tick and input of a message.

    Args:
        data: The message, from anyone.
        base: The recording's own map.
        file: The recording, for errors.

    Raises:
        RecordingError: The message is no input, or one of another map or skin.
    """
    message = load_json(InputMessage, data, error=RecordingError, place="/input", file=file, remedy=DAMAGED)
    found = message.input
    if isinstance(found, PokePressed | PokeMoved):
        check_place(found.at, base.skin, place="/input: input.at", file=file)
    if isinstance(found, CalibrationUsed):
        _check_calibration(found, len(base.skin), file)
    if not isinstance(found, MapEdit):
        return message.tick, found
    try:
        return message.tick, MapEdited(found.name, edit_from_bytes(found.map, base))
    except TactileMapsError as error:
        place = ", ".join(filter(None, ("/input: input.map", error.place)))
        raise RecordingError(error.problem, file=file, place=place, value=error.value, remedy=DAMAGED) from error


def encode_event(event: ContactEvent) -> bytes:
    """One event as a message. Cost: 20 µs."""
    return dump_json(EventMessage(event, event.words))


def decode_event(data: bytes, skin: Skin, *, file: str | None = None) -> ContactEvent:
    """The event of a message.

    Args:
        data: The message, from anyone.
        skin: On which it happened.
        file: The recording, for errors.

    Raises:
        RecordingError: The message is no contact event, or none on this skin.
    """
    message = load_json(EventMessage, data, error=RecordingError, place="/event", file=file, remedy=DAMAGED)
    places: dict[str, SurfacePoint | None] = {"at": message.event.at, "to": message.event.to}
    for name, at in places.items():
        if at is not None:
            check_place(at, skin, place=f"/event: event.{name}", file=file)
    return message.event


def encode_mark(mark: Mark) -> bytes:
    """A mark as a message."""
    return dump_json(mark)


def decode_mark(data: bytes, *, file: str | None = None) -> Mark:
    """The mark of a message.

    Raises:
        RecordingError: The message is no mark.
    """
    return load_json(Mark, data, error=RecordingError, place="/mark", file=file, remedy=DAMAGED)


def encode_failure(tick: int, error: SimulationError) -> bytes:
    """Why a session stopped at ``tick``, as a message."""
    value = None if error.value is None else str(error.value)
    return dump_json(FailureMessage(tick, "SimulationError", error.problem, error.place, value, error.remedy))


def decode_failure(data: bytes, *, file: str | None = None) -> tuple[int, SimulationError]:
    """Tick and error of a message; the error reads as it did.

    Raises:
        RecordingError: The message is no failure.
    """
    told = load_json(FailureMessage, data, error=RecordingError, place="/failure", file=file, remedy=DAMAGED)
    return told.tick, SimulationError(told.problem, place=told.place, value=told.value, remedy=told.remedy)


def _schema(kind: type, title: str) -> str:
    """The schema, its parts in ``allOf``: viewers that know only plain types at the top (Foxglove, Lichtblick) refuse a
    topic whose schema has choices there, and read this one.
    """
    exact = json_schema(kind)
    description = (kind.__doc__ or "").partition("\n")[0]
    plain = {name: part for name, part in exact["properties"].items() if part.get("type") in _PLAIN}
    return json.dumps(
        {"title": title, "description": description, "type": "object", "properties": plain, "allOf": [exact]}
    )


_PLAIN = ("boolean", "integer", "number", "string")


class Topic(NamedTuple):
    """What a channel says of its messages: the schema's name, encoding and data, and the messages' own encoding."""

    name: str
    schema_encoding: str
    schema: bytes
    encoding: str


def _json_topic(kind: type, name: str) -> Topic:
    return Topic(name, "jsonschema", _schema(kind, name).encode(), "json")


TOPICS: Mapping[str, Topic] = MappingProxyType(
    {
        "/frame": Topic("tactile_maps.Frame", "protobuf", FRAME_SCHEMA, "protobuf"),
        "/input": _json_topic(InputMessage, "tactile_maps.Input"),
        "/failure": _json_topic(FailureMessage, "tactile_maps.Failure"),
        "/event": _json_topic(EventMessage, "tactile_maps.ContactEvent"),
        "/mark": _json_topic(Mark, "tactile_maps.Mark"),
    }
)
"""By topic."""
