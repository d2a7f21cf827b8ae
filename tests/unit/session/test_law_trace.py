"""A trace is collected tick by tick and never changes again."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.session.law_trace import NUMBERS, TraceRows


def test_what_there_is_not_is_nan():
    rows = TraceRows()
    numbers = dict.fromkeys(NUMBERS, 1.0) | {"map_error": None}
    rows.add(touched=True, limits=("joint limit",), **numbers)
    trace = rows.trace("A", ControlSettings(law="qp"), "")
    assert (len(trace), trace.name, trace.settings.law, trace.ended) == (1, "A", "qp", "")
    assert np.isnan(trace.map_error[0])
    assert all(getattr(trace, name)[0] == 1.0 for name in NUMBERS if name != "map_error")
    assert (list(trace.touched), trace.limits) == ([True], (("joint limit",),))
    for name in (*NUMBERS, "touched"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(trace, name)[0] = 0


def test_one_without_a_tick_is_empty():
    trace = TraceRows().trace("A", ControlSettings(), "stopped at once")
    assert len(trace) == 0
    assert trace.force.shape == trace.touched.shape == (0,)
