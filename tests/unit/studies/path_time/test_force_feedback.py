"""The factors of force feedback: who estimates, with and without a finger elsewhere."""

from __future__ import annotations

from tactile_maps.studies.path_time.force_feedback import FACTORS


def test_the_lumped_sensor_is_tried_with_a_finger_elsewhere_and_without():
    factor = next(item for item in FACTORS if item.name == "estimator")
    made = {level: factor.conditions(level) for level in factor.levels}
    assert {(found.estimator, found.touched) for found in made.values()} >= {
        ("lumped", False),
        ("lumped", True),
        ("area-sum", True),
    }
