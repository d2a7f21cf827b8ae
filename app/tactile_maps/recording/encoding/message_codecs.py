"""Inputs, contact events, marks and failures as JSON messages, which any MCAP reader can decode; the list of topics.

Each message is one of the dataclasses here. ``tactile_maps.core.codec`` writes them, reads them strictly and generates
their schemas. Frames have their own codec, ``frame_codec``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

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
from tactile_maps.tactile.poke import PokeInput, PokeMoved, PokePressed, PokePulled


@dataclass(frozen=True)
class MapEdit:
    """``MapEdited`` without the data that are already in the recording.

    Attributes:
        name: Name of the edit for display.
        map: Difference between the map and the recording's own one, see ``edit_to_bytes``.
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
    """A contact event, with a description in words for readers of the file."""

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
    """Return an input as a message; ``base`` is the recording's own map.

    Cost: 20 µs; for an edit that of ``edit_to_bytes``.

    Raises:
        RecordingError: The map belongs to a skin with other triangles than the recording's, such as a map learned
            between taxels. Locations on the two skins differ, so frames could not be decoded with it.
    """
    if not isinstance(session_input, MapEdited):
        return dump_json(InputMessage(tick, session_input))
    if not all(map(same_triangles, session_input.map.skin.patches, base.skin.patches)):
        remedy = "Record with a map of the skin that is simulated"
        raise RecordingError("a recording cannot store a map whose triangles are not the skin's", remedy=remedy)
    return dump_json(InputMessage(tick, MapEdit(session_input.name, edit_to_bytes(session_input.map, base))))


def _check_calibration(found: CalibrationUsed, taxels: int, file: str | None) -> None:
    points = () if found.curve is None else found.curve.shape[-1:]
    shapes = {"curve": (taxels, 2, *points), "shear_baseline": (taxels, 2), "matrix": (taxels, 3, 3)}
    shapes |= dict.fromkeys(("gain", "offset", "baseline", "spread"), (taxels,))
    for name, shape in shapes.items():
        values = getattr(found, name)
        if values is not None and values.shape != shape:
            problem = "the calibration is of another skin"
            raise RecordingError(problem, file=file, place=f"/input: input.{name}", value=values.shape, remedy=DAMAGED)
    if found.broken.ndim != 1 or not ((found.broken >= 0) & (found.broken < taxels)).all():
        problem = "invalid number of a broken taxel"
        raise RecordingError(problem, file=file, place="/input: input.broken", value=found.broken, remedy=DAMAGED)
    if found.stuck.ndim != 1 or not np.isin(found.stuck, found.broken).all():
        problem = "a stuck taxel is not among the broken ones"
        raise RecordingError(problem, file=file, place="/input: input.stuck", value=found.stuck, remedy=DAMAGED)


def decode_input(data: bytes, base: TactileMap, *, file: str | None = None) -> tuple[int, SessionInput]:
    """Return tick and input of a message.

    Args:
        data: The untrusted message.
        base: The recording's own map.
        file: The recording, for errors.

    Raises:
        RecordingError: The message is not a valid input for this map and skin.
    """
    message = load_json(InputMessage, data, error=RecordingError, place="/input", file=file, remedy=DAMAGED)
    found = message.input
    if isinstance(found, PokePressed | PokeMoved | PokePulled):
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
    """Return an event as a message. Cost: 20 µs."""
    return dump_json(EventMessage(event, event.words))


def decode_event(data: bytes, skin: Skin, *, file: str | None = None) -> ContactEvent:
    """Return the event of a message.

    Args:
        data: The untrusted message.
        skin: Skin of the recording.
        file: The recording, for errors.

    Raises:
        RecordingError: The message is not a valid contact event on this skin.
    """
    message = load_json(EventMessage, data, error=RecordingError, place="/event", file=file, remedy=DAMAGED)
    places: dict[str, SurfacePoint | None] = {"at": message.event.at, "to": message.event.to}
    for name, at in places.items():
        if at is not None:
            check_place(at, skin, place=f"/event: event.{name}", file=file)
    return message.event


def encode_mark(mark: Mark) -> bytes:
    """Return a mark as a message."""
    return dump_json(mark)


def decode_mark(data: bytes, *, file: str | None = None) -> Mark:
    """Return the mark of a message.

    Raises:
        RecordingError: The message is not a valid mark.
    """
    return load_json(Mark, data, error=RecordingError, place="/mark", file=file, remedy=DAMAGED)


def encode_failure(tick: int, error: TactileMapsError) -> bytes:
    """Return the error that stopped a session at ``tick`` as a message."""
    value = None if error.value is None else str(error.value)
    return dump_json(FailureMessage(tick, "SimulationError", error.problem, error.place, value, error.remedy))


def decode_failure(data: bytes, *, file: str | None = None) -> tuple[int, SimulationError]:
    """Return tick and error of a message; the error has the same text as the original.

    Raises:
        RecordingError: The message is not a valid failure.
    """
    found = load_json(FailureMessage, data, error=RecordingError, place="/failure", file=file, remedy=DAMAGED)
    return found.tick, SimulationError(found.problem, place=found.place, value=found.value, remedy=found.remedy)


def _schema(kind: type, title: str) -> str:
    """Return the JSON schema of a message, with its exact form in ``allOf``: viewers that support only plain types at
    the top level (Foxglove, Lichtblick) reject schemas with alternatives there.
    """
    exact = json_schema(kind)
    description = (kind.__doc__ or "").partition("\n")[0]
    plain = {name: part for name, part in exact["properties"].items() if part.get("type") in _PLAIN}
    return json.dumps(
        {"title": title, "description": description, "type": "object", "properties": plain, "allOf": [exact]}
    )


_PLAIN = ("boolean", "integer", "number", "string")


class Topic(NamedTuple):
    """Description of a channel: name, encoding and data of the schema, and encoding of the messages."""

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
"""Description of each topic."""
