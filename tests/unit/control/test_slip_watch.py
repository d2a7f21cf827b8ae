"""A contact that goes along with the skin is noticed; one that slides is not taken for it."""

from __future__ import annotations

import numpy as np

from app.control.slip_watch import AGAIN, LONGEST, SlipWatch

DT, ERROR, ASKED = 0.005, np.array([0.01, 0.0]), np.array([0.04, 0.0])


def watched(share, *, asked=ASKED, seconds=2.0, jump_at=-1):
    watch, point = SlipWatch(0.005), np.zeros(2)
    for tick in range(round(seconds / DT)):
        point = point + share * asked * DT + (np.array([-0.3, 0.2]) if tick == jump_at else 0.0)
        watch.look(1, point, ERROR, asked, DT)
    return watch


def test_one_that_comes_along_is_stuck_and_one_that_slides_is_not():
    assert watched(0.0).stuck
    assert watched(-1.0).stuck
    assert not watched(0.5).stuck
    assert not watched(1.0, jump_at=40).stuck, "over a seam the place jumps"


def test_little_is_no_proof():
    assert not watched(0.0, seconds=0.2).stuck
    assert not watched(0.0, asked=0.02 * ASKED, seconds=3 * LONGEST).stuck


def test_it_is_tried_again_when_the_error_changed_or_another_contact_comes():
    watch = watched(0.0)
    assert watch.look(1, np.zeros(2), ERROR, ASKED, DT)
    assert not watch.look(1, np.zeros(2), ERROR + [0, 1.1 * AGAIN], ASKED, DT)
    assert not watched(0.0).look(2, np.zeros(2), ERROR, ASKED, DT)
    watch = watched(0.0)
    watch.reset()
    assert not watch.look(1, np.zeros(2), ERROR, ASKED, DT)
