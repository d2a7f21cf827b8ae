"""Taxels below a cover, their readings, and the region that a contact is found in."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.studies.testbeds.covered_lattice import (
    AREA,
    PITCH,
    TAXELS,
    area_blur,
    contact_region,
    exact_readings,
)


def test_what_the_taxels_read_adds_up_to_the_force():
    for readings in exact_readings(8e-3, 0.5 * PITCH):
        assert AREA * readings.sum() == pytest.approx(1.0, abs=0.05)


def test_even_pressure_is_read_as_it_is_in_the_middle():
    middle = np.linalg.norm(TAXELS, axis=1).argmin()
    assert area_blur(0.5 * PITCH)[middle].sum() == pytest.approx(1.0, abs=0.05)


def test_a_region_is_one_piece_about_the_peak_and_its_ring():
    readings = np.zeros(len(TAXELS))
    first = int(np.linalg.norm(TAXELS, axis=1).argmin())
    far = 0
    readings[first] = 100.0
    readings[far] = 50.0
    core, ring = contact_region(readings, 1.0)
    assert core.tolist() == [first]
    assert len(ring) == 7
    assert far not in ring
