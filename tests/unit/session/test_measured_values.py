"""What a real skin sent goes through a recording bit by bit, with what it may be called."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import RecordingError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.recording.encoding.frame_codec import decode_frame, encode_frame
from tactile_maps.session.measured_values import MeasuredValues
from tests.support.touch import prepared_bar

RAW = np.where(np.arange(60) == 7, np.nan, np.arange(60.0))
SENT = MeasuredValues(RAW, "counts", 12.5, 3, ReadingUnits.COUNTS)


@pytest.fixture(scope="module")
def session():
    return MeasuredSession(as_measured(prepared_bar()))


def test_a_simulated_frame_has_none_and_is_calibrated(session):
    frame = replace(session.frame, measured=None)
    assert frame.units is ReadingUnits.CALIBRATED
    assert decode_frame(encode_frame(frame), session.prepared).measured is None


def test_what_was_sent_is_read_back(session):
    back = decode_frame(encode_frame(replace(session.frame, measured=SENT)), session.prepared)
    assert back.units is ReadingUnits.COUNTS
    assert np.array_equal(back.measured.raw, RAW, equal_nan=True)
    assert (back.measured.unit, back.measured.sent, back.measured.sequence) == ("counts", 12.5, 3)
    with pytest.raises(ValueError, match="read-only"):
        back.measured.raw[0] = 1.0


@pytest.mark.parametrize("raw", [RAW[:9], np.zeros(0), np.full(60, np.inf)])
def test_what_no_skin_sends_is_refused(session, raw):
    data = encode_frame(replace(session.frame, measured=replace(SENT, raw=raw)))
    with pytest.raises(RecordingError, match="raw value"):
        decode_frame(data, session.prepared)
