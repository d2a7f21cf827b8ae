"""Why a session stopped by itself, as a JSON message.

{"tick": n, "problem": text, "place": text, "value": text, "remedy": text}, the last three null where there is none.
"""

from __future__ import annotations

import json

from app.errors import RecordingError, SimulationError

_REASONS = ("place", "value", "remedy")
FAILURE_SCHEMA = json.dumps(
    {
        "title": "tactile_maps.Failure",
        "type": "object",
        "required": ["tick", "problem", *_REASONS],
        "properties": {"tick": {"type": "integer"}, "problem": {"type": "string"}},
    }
)


def encode_failure(tick: int, error: SimulationError) -> bytes:
    """Why a session stopped at ``tick``, as a message."""
    reasons = {name: None if getattr(error, name) is None else str(getattr(error, name)) for name in _REASONS}
    return json.dumps({"tick": tick, "problem": error.problem, **reasons}).encode()


def decode_failure(data: bytes) -> tuple[int, SimulationError]:
    """Tick and error of a message; the error reads as it did.

    Raises:
        RecordingError: The message is no failure.
    """
    try:
        raw = json.loads(data)
        reasons = {name: None if raw[name] is None else str(raw[name]) for name in _REASONS}
        return int(raw["tick"]), SimulationError(str(raw["problem"]), **reasons)
    except (ValueError, KeyError, TypeError) as error:
        raise RecordingError("the failure that ended the recording is damaged", value=error) from error
