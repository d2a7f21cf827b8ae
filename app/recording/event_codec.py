"""Contact events as JSON messages, which any program that reads MCAP can read.

    {"tick": n, "time": s, "kind": "press", "phase": "ended", "contacts": [ids], "links": [names], "at": place,
     "to": place or null, "force": N, "duration": s, "travelled": m, "words": "press on forearm, 4.2 N, 0.8 s"}

A place is {"patch": n, "face": n, "weights": [3 numbers]}; floats are written so that they read back equal.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from app.contacts.event import EVENT_KINDS, ContactEvent
from app.errors import RecordingError
from app.geometry.surface_point import SurfacePoint

_PLACE = {
    "type": "object",
    "required": ["patch", "face", "weights"],
    "properties": {
        "patch": {"type": "integer"},
        "face": {"type": "integer"},
        "weights": {"type": "array", "items": {"type": "number"}},
    },
}
_PROPERTIES: dict[str, Any] = {
    "tick": {"type": "integer"},
    "time": {"type": "number"},
    "kind": {"enum": list(EVENT_KINDS)},
    "phase": {"enum": ["began", "ended"]},
    "contacts": {"type": "array", "items": {"type": "integer"}},
    "links": {"type": "array", "items": {"type": "string"}},
    "at": _PLACE,
    "to": {"oneOf": [_PLACE, {"type": "null"}]},
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
        "required": list(_PROPERTIES),
        "properties": _PROPERTIES,
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
            at=_place(raw["at"]),
            to=None if raw["to"] is None else _place(raw["to"]),
            force=float(raw["force"]),
            duration=float(raw["duration"]),
            travelled=float(raw["travelled"]),
        )
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise RecordingError("a contact event of the recording is damaged", value=error) from error


def _place(raw: Any) -> SurfacePoint:
    a, b, c = (float(weight) for weight in raw["weights"])
    return SurfacePoint(int(raw["patch"]), int(raw["face"]), (a, b, c))
