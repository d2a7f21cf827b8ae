"""Estimates as values."""

from __future__ import annotations

import numpy as np

from app.contacts.estimators.estimate import ForceEstimate


def test_it_owns_its_arrays():
    forces = np.ones(2)
    found = ForceEstimate(2.0, None, np.array([3, 4]), forces)
    forces[0] = 9
    assert found.forces[0] == 1
    assert not found.taxels.flags.writeable


def test_misfit_is_residual_over_noise():
    assert ForceEstimate(1.0, None, residual=200.0, noise=100.0).misfit == 2.0
    assert ForceEstimate(1.0, None, residual=200.0).misfit == float("inf")
    assert ForceEstimate(1.0, None).misfit == 0.0
