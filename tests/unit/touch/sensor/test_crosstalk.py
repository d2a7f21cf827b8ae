from __future__ import annotations

import numpy as np
import pytest

from app.touch.sensor.crosstalk import Crosstalk
from tests.sensors import readings, refuses, row, stage


def test_a_taxel_gives_its_share_to_its_neighbours_in_equal_parts():
    at_work = stage(Crosstalk(share=0.1), 5)
    assert readings(at_work, [[0, 0, 1000, 0, 0]])[0] == pytest.approx([0, 50, 900, 50, 0])
    assert readings(at_work, [[1000, 0, 0, 0, 0]])[0] == pytest.approx([900, 100, 0, 0, 0])


def test_it_is_force_that_is_given_so_a_taxel_twice_as_large_reads_half_of_it():
    at_work = stage(Crosstalk(share=0.1), skin=row(2, areas=[1e-4, 2e-4]))
    assert readings(at_work, [[1000, 0]])[0] == pytest.approx([900, 50])


def test_a_taxel_without_neighbours_keeps_all():
    at_work = stage(Crosstalk(share=0.9), skin=row(3, neighbours=[(0, 1)]))
    assert readings(at_work, [[0, 0, 1000]])[0].tolist() == [0, 0, 1000]
    assert readings(stage(Crosstalk()), [[1000]])[0].tolist() == [1000]


def test_it_remembers_nothing():
    at_work = stage(Crosstalk(), 5)
    first = readings(at_work, [[0, 0, 1000, 0, 0]])
    assert at_work.state().shape == (0,)
    at_work.reset()
    assert np.array_equal(readings(at_work, [[0, 0, 1000, 0, 0]]), first)


def test_a_share_out_of_range_is_refused():
    refuses(Crosstalk, "share", -0.01, 0.91)
