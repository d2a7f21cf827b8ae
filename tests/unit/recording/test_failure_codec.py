"""Messages hold what stopped a session in the same words, and refuse what does not."""

from __future__ import annotations

import pytest

from app.errors import RecordingError, SimulationError
from app.recording.failure_codec import decode_failure, encode_failure


@pytest.mark.parametrize("error", [
    SimulationError("the simulation diverged", place="joint a at 0.1 s", value=float("nan"), remedy="Reset"),
    SimulationError("the simulation diverged"),
])  # fmt: skip
def test_a_failure_reads_as_it_did(error):
    tick, again = decode_failure(encode_failure(12, error))
    assert (tick, str(again)) == (12, str(error))


@pytest.mark.parametrize("data", [b"", b"{}", b"[]", b'{"tick": 1, "problem": "x"}', b'{"tick": "soon"}'])
def test_a_damaged_failure_is_refused_by_name(data):
    with pytest.raises(RecordingError, match="failure that ended the recording is damaged"):
        decode_failure(data)
