"""The factors of representation: learned maps by touch of two kinds, covers by thickness over pitch."""

from __future__ import annotations

import pytest

from tactile_maps.studies.path_time.representation import BIASED, FACTORS


def conditions(factor: str, level: float | str):
    return next(item for item in FACTORS if item.name == factor).conditions(level)


def test_learned_maps_come_from_two_kinds_of_touch():
    levels = next(factor for factor in FACTORS if factor.name == "map learned").levels
    kinds = [(conditions("map learned", level).map, conditions("map learned", level).touch) for level in levels]
    assert len(set(kinds)) == len(levels) == 10
    assert conditions("map learned", f"self-organising{BIASED}").touch == "biased"


def test_a_cover_is_as_many_pitches_thick():
    layer = conditions("cover", 2.0).layer
    assert (layer.thickness, layer.depth) == pytest.approx((0.016, 0.008))
