"""A frame is an instant that nobody can change afterwards."""

from __future__ import annotations

import numpy as np

from app.control.command import JointCommand
from app.session.frame import Frame


def test_it_owns_its_arrays():
    none, pressures = np.zeros(0), np.zeros(3)
    frame = Frame(1, 0.005, none, none, pressures, (), (), JointCommand(none, none, none, none))
    pressures[0] = 1
    assert frame.pressures[0] == 0
    assert not frame.posture.flags.writeable
    assert frame.timings.total_ms == 0
    assert frame.why_limited == frame.notes == ()
    assert frame.objects.shape == (0, 4, 4)
