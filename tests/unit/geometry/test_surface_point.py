from __future__ import annotations

import dataclasses

import pytest

from app.geometry.surface_point import SurfacePoint


def test_it_is_a_frozen_value_that_can_be_a_key() -> None:
    at = SurfacePoint(0, 7, (0.2, 0.3, 0.5))
    assert {at: 1}[SurfacePoint(0, 7, (0.2, 0.3, 0.5))] == 1
    with pytest.raises(dataclasses.FrozenInstanceError):
        at.face = 3  # type: ignore[misc]
