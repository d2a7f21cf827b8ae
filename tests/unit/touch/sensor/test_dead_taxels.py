from __future__ import annotations

import numpy as np
import pytest

from app.errors import SimulationError
from app.touch.sensor.dead_taxels import ALIVE, DEAD, STUCK, DeadTaxels
from tests.sensors import readings, refuses, stage


def test_the_dead_read_nothing_the_stuck_always_the_same_the_others_what_they_feel():
    at_work = stage(DeadTaxels(dead=0.3, stuck=0.2, stuck_at=7.0), 10)
    (read,) = readings(at_work, [np.full(10, 1000.0)])
    assert (read[at_work.codes == DEAD] == 0).all()
    assert (read[at_work.codes == STUCK] == 7.0).all()
    assert (read[at_work.codes == ALIVE] == 1000.0).all()
    assert [np.count_nonzero(at_work.codes == code) for code in (ALIVE, DEAD, STUCK)] == [5, 3, 2]


def test_what_enters_is_not_changed_and_what_broke_stays_broken():
    at_work, pressures = stage(DeadTaxels(dead=1.0), 4), np.ones(4)
    codes = at_work.codes.copy()
    assert not at_work.read(pressures).any()
    assert pressures.all()
    at_work.reset()
    assert np.array_equal(at_work.codes, codes)
    assert at_work.state().shape == (0,)
    assert not at_work.codes.flags.writeable


def test_a_larger_share_breaks_the_same_and_more():
    fewer, more = (stage(DeadTaxels(dead=s, stuck=s), 100).codes for s in (0.1, 0.4))
    for code in (DEAD, STUCK):
        assert (more[fewer == code] == code).all()


def test_no_taxel_is_both():
    assert stage(DeadTaxels(dead=0.5, stuck=0.5), 3).codes.tolist().count(ALIVE) == 0
    assert stage(DeadTaxels(dead=0.7, stuck=0.3), 1000).codes.tolist().count(DEAD) == 700


def test_shares_out_of_range_are_refused_also_together():
    refuses(DeadTaxels, "dead", -0.01, 1.01)
    refuses(DeadTaxels, "stuck", -0.01, 1.01)
    refuses(DeadTaxels, "stuck_at", -1.0, 1.1e9)
    with pytest.raises(SimulationError, match="dead and stuck together"):
        DeadTaxels(dead=0.6, stuck=0.5)
