"""Contacts followed through motion, noise, meeting and parting, on a flat skin where the truth is known."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from app.contacts.reader import THRESHOLD, ContactReader
from app.maps.build import build_map
from tests.touch import bar_skin

SKIN = bar_skin(400)
MAP = build_map(SKIN)
POSITIONS = SKIN.patches[0].taxels.positions
RADIUS = 0.025


def press(*centres, kilopascals=20.0) -> np.ndarray:
    """Round touches, each of one strength, on the bar's top."""
    total = np.zeros(len(SKIN))
    for x, y in centres:
        away = np.linalg.norm(POSITIONS - [x, y, 0.02], axis=1)
        total += 1e3 * kilopascals * np.clip(1 - (away / RADIUS) ** 2, 0, None)
    return total


@pytest.mark.parametrize("pace", [0.001, 0.005, 0.02])
@pytest.mark.parametrize("noise", [0.0, 150.0])
def test_a_wandering_contact_is_one_and_where_it_is(pace, noise):
    """Up to 20 mm from frame to frame, two pitches: 4 m/s at 200 Hz."""
    random, reader, missed = np.random.default_rng(0), ContactReader(MAP), []
    for step in range(200):
        x = 0.2 + 0.15 * np.sin(pace / 0.15 * step)
        regions = reader.read(press((x, 0.0)) + random.normal(0, noise, len(SKIN)) * (noise > 0))
        assert [region.id for region in regions] == [1]
        missed.append(np.linalg.norm(regions[0].point - [x, 0, 0.02]))
    assert max(missed) < 0.0015, "a seventh of the pitch"


def test_two_that_pass_through_each_other():
    """Apart they keep their names; together they go by the older's; parted, one of them has a new name."""
    reader, seen = ContactReader(MAP), []
    reader.read(press((0.08, 0.0)))
    for way in np.arange(0.0, 0.24, 0.004):
        regions = reader.read(press((0.08 + way, 0.0), (0.32 - way, 0.0)))
        seen.append(
            (tuple(sorted(r.id for r in regions)), [r.merged for r in regions if r.merged],
             [(r.id, r.split_from) for r in regions if r.split_from])
        )  # fmt: skip
    ids = [names for names, _, _ in seen]
    assert ids[0] == (1, 2)
    assert ids[-1] == (1, 3)
    changes = [(a, b) for a, b in pairwise(ids) if a != b]
    assert changes == [((1, 2), (1,)), ((1,), (1, 3))]
    assert [told for _, told, _ in seen if told] == [[(2,)]], "the merging is told once"
    assert [told for _, _, told in seen if told] == [[(3, 1)]], "so is the parting"


def test_of_three_in_a_chain_the_oldest_lives_on():
    reader, places = ContactReader(MAP), [(0.3, 0.0), (0.2, 0.0), (0.1, 0.0)]
    for count in (1, 2, 3):
        reader.read(press(*places[:count]))
    (region,) = reader.read(press(*places, (0.15, 0.0), (0.25, 0.0)))
    assert (region.id, region.merged) == (1, (2, 3))


def test_nothing_is_counted_twice_or_lost():
    """Whatever is pressed: each touched taxel is in one region, and ids are all different."""
    random, reader = np.random.default_rng(0), ContactReader(MAP)
    for _ in range(100):
        count = int(random.integers(0, 5))
        centres = np.column_stack([random.uniform(0.03, 0.37, count), random.uniform(-0.04, 0.04, count)])
        pressures = press(*centres)
        regions = reader.read(pressures)
        assert len({region.id for region in regions}) == len(regions)
        assert list(regions) == sorted(regions, key=lambda region: -region.force)
        touched = np.flatnonzero(pressures >= THRESHOLD)
        held = np.bincount(
            np.concatenate([region.taxels for region in regions] or [[]]).astype(int), minlength=len(SKIN)
        )
        assert (held[touched] >= 1).all()
        total = sum(region.force for region in regions)
        assert total >= 0.97 * float(pressures @ SKIN.areas), "rings bring what is below the threshold"
        reader.reset()


def test_the_ring_brings_what_the_threshold_loses():
    """Without it, the touched taxels alone lose force; with it the sum is whole."""
    pressures = press((0.2, 0.0), kilopascals=4.0)
    (region,) = ContactReader(MAP).read(pressures)
    alone = float(pressures[pressures >= THRESHOLD] @ SKIN.areas[pressures >= THRESHOLD])
    assert alone < 0.95 * region.force
    assert region.force == pytest.approx(float(pressures @ SKIN.areas), rel=0.01)
