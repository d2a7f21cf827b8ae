"""What may be asked for, and what is refused with a reason."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import SkinError
from app.skin.placement_spec import Ball, BorderStrip, Box, Painted, PlacementSpec


@pytest.mark.parametrize(
    ("wanted", "problem"),
    [
        ({}, "state the pitch or the number"),
        ({"pitch": 0.01, "taxels": 5}, "state the pitch or the number"),
        ({"pitch": 0.0}, "pitch cannot be made"),
        ({"pitch": float("nan")}, "pitch cannot be made"),
        ({"taxels": 0}, "number of taxels"),
        ({"taxels": 10**6}, "number of taxels"),
        ({"taxels": 5, "pattern": "square"}, "no such pattern"),
        ({"taxels": 5, "density": "dense"}, "no such density"),
        ({"taxels": 5, "density": np.array([1.0, 0.0])}, "above zero"),
        ({"taxels": 5, "density": np.array([1.0, np.inf])}, "above zero"),
        ({"taxels": 5, "density": "curvature", "pattern": "hexagonal"}, "only the even pattern"),
        ({"taxels": 50, "pattern": "modules"}, "as many modules"),
    ],
)
def test_what_cannot_be_placed_is_refused(wanted, problem):
    with pytest.raises(SkinError, match=problem):
        PlacementSpec(**wanted)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Ball(np.zeros(3), 0.0),
        lambda: Ball(np.zeros(2), 1.0),
        lambda: Ball(np.full(3, np.nan), 1.0),
        lambda: Box(np.ones(3), np.zeros(3)),
        lambda: BorderStrip(-1.0),
    ],
)
def test_zones_without_a_meaning_are_refused(make):
    with pytest.raises(SkinError):
        make()


def test_values_are_frozen():
    density = np.ones(3)
    spec = PlacementSpec(taxels=3, density=density)
    density[0] = 9
    assert spec.density.tolist() == [1, 1, 1]
    assert not spec.density.flags.writeable
    assert not Ball(np.zeros(3), 1.0).centre.flags.writeable


def test_modules_need_no_number():
    assert PlacementSpec(pattern="modules").pitch is None


def test_a_part_takes_its_share_of_what_is_painted():
    ball = Ball(np.zeros(3), 1.0)
    zones = (ball, Painted(np.array([True, False, True])))
    part = PlacementSpec(taxels=9, density=np.arange(1.0, 4.0), keep_out=zones).on_part(np.array([2, 1]), taxels=4)
    assert part.taxels == 4
    assert part.density.tolist() == [3, 2]
    assert part.keep_out[0] is ball
    assert part.keep_out[1].vertices.tolist() == [True, False]
    assert PlacementSpec(pitch=0.01, density="curvature").on_part(np.array([0])).density == "curvature"
