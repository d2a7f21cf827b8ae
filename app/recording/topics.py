"""What a recording's messages are about; each kind has a codec of its own."""

from __future__ import annotations

from app.recording.event_codec import EVENT_SCHEMA
from app.recording.failure_codec import FAILURE_SCHEMA
from app.recording.frame_codec import FRAME_SCHEMA
from app.recording.input_codec import INPUT_SCHEMA

TOPICS = {
    "/frame": ("tactile_maps.Frame", FRAME_SCHEMA, "tactile_maps.Frame"),
    "/input": ("tactile_maps.Input", INPUT_SCHEMA, "json"),
    "/failure": ("tactile_maps.Failure", FAILURE_SCHEMA, "json"),
    "/event": ("tactile_maps.ContactEvent", EVENT_SCHEMA, "json"),
}
"""By topic: schema's name and text, and the encoding of a message."""
