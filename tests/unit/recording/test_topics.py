"""Every kind of message has a topic with a schema."""

from __future__ import annotations

import json

from app.recording.topics import TOPICS


def test_every_schema_is_json_and_named_as_its_topic_says():
    assert set(TOPICS) == {"/frame", "/input", "/failure", "/event"}
    for name, text, _encoding in TOPICS.values():
        assert json.loads(text)["title"] == name
