"""One contact's phases follow each other without a gap."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.course import Course, EventRule
from tests.unit.contacts.regions_by_hand import region


@pytest.mark.parametrize("seed", range(5))
def test_whatever_it_does_each_phase_begins_where_the_last_one_ended(seed):
    random, at, rule = np.random.default_rng(seed), np.zeros(3), EventRule()
    course, events = Course(0, 0.0, region(1), rule), []
    for tick in range(1, 2000):
        if tick % 200 == 0:
            pace = random.normal(0, 3e-4, 3) * random.integers(2)
        at = at + (pace if tick >= 200 else 0)
        events += course.go_on(tick, 0.005 * tick, region(1, point=at, force=float(random.uniform(1, 5))))
    events += course.end(2000, 10.0, released=True)
    phases = [event for event in events if event.kind in ("press", "stroke")]
    assert len(phases) > 4
    for began, ended in zip(phases[::2], phases[1::2], strict=True):
        assert (began.phase, ended.phase, began.kind) == ("began", "ended", ended.kind)
        assert began.time <= ended.time
        assert ended.force <= 5.0
    assert events[-1].kind == "release"
    assert events[-1].duration == 10.0
