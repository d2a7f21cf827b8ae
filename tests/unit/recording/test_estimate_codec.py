"""Force estimates in a frame's message."""

from __future__ import annotations

import json
from dataclasses import fields

import numpy as np
import pytest

from app.contacts.estimators.estimate import ForceEstimate
from app.geometry.surface_point import SurfacePoint
from app.recording.estimate_codec import estimates_from_json, estimates_to_json

TOLD = ForceEstimate(
    1 / 3, SurfacePoint(1, 2, (0.1, 0.2, 0.7)), np.array([3, 5]), np.array([0.1, 1 / 3 - 0.1]), float("inf"), 1, 2,
    12.5, 1 / 7, peak=1e4 / 3, mean=1e3 / 3, force_error=1e-3, place_error=2e-3,
)  # fmt: skip
REFUSED = ForceEstimate(2.0, None, refused="No force is felt")


def test_they_read_back_to_the_last_bit():
    plain = ForceEstimate(1.0, None)
    names = [field.name for field in fields(ForceEstimate) if field.name not in ("refused",)]
    same = [name for name in names if np.array_equal(getattr(TOLD, name), getattr(plain, name))]
    assert not same, "each field must differ from its usual value here"
    again = estimates_from_json(json.loads(json.dumps(estimates_to_json({4: TOLD, 9: REFUSED}))))
    assert again.keys() == {4, 9}
    for one, other in ((again[4], TOLD), (again[9], REFUSED)):
        for field in fields(one):
            assert np.array_equal(getattr(one, field.name), getattr(other, field.name)), field.name


@pytest.mark.parametrize("change", [{"force": "much"}, {"at": [1, 2]}, {"taxels": "all"}, {"at": 3}])
def test_damage_is_noticed(change):
    raw = json.loads(json.dumps(estimates_to_json({4: TOLD})))
    raw["4"] |= change
    with pytest.raises((ValueError, TypeError, KeyError, IndexError)):
        estimates_from_json(raw)
