"""Fingers that cross, meet and turn back on a flat skin: every finger has its own contact again, with the same id.

The truth is known: which finger is where, and how hard it presses. A finger presses with a paraboloid of pressure.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from tactile_maps.contacts.detection.detection import ContactDetector
from tactile_maps.core.arrays import FloatArray
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tests.support.surfaces import sheet

pytestmark = pytest.mark.long

SIDE = 24
"""Taxels along a side of the skin."""


@cache
def map_of(pitch: float) -> TactileMap:
    side = SIDE * pitch
    surface = sheet(48, 48, width=side, height=side)
    return build_map(Skin((Patch("sheet", "sheet", surface, place_evenly(surface, SIDE**2, seed=1)),)))


class Fingers:
    """A few fingers that meet in the middle of a skin and separate.

    ``straight``: each crosses at its own speed. ``pause``: they stop where they meet, then continue. ``back``: they
    stop, then return.
    """

    def __init__(self, kind: str, seed: int, *, ratio: float, count: int) -> None:
        random = np.random.default_rng((seed, count))
        self.kind = kind
        self.pitch = float(random.choice([0.004, 0.006, 0.01]))
        self.rate = float(random.choice([50, 100, 200, 500]))
        turns = np.array([0, random.uniform(np.pi / 3, np.pi)]) if count == 2 else 2 * np.pi / 3 * np.arange(3)
        turns = turns + random.uniform(0, 2 * np.pi) + random.uniform(-0.2, 0.2, count)
        self.ahead = np.stack([np.cos(turns), np.sin(turns)], axis=1)
        self.aside = random.uniform(-0.8, 0.8, (count, 1)) * self.pitch * self.ahead[:, ::-1] * [-1, 1]
        self.speed = random.uniform(0.03, 0.15) * (random.uniform(0.8, 1.25, count) if kind == "straight" else 1.0)
        self.reach = 9 * self.pitch
        self.stop = -1.2 * self.pitch
        self.dwell = random.uniform(0.05, 0.6)
        self.forces = random.permutation(ratio ** np.arange(count)) * random.uniform(0.5, 4) * (self.pitch / 0.006) ** 2
        self.radius = random.uniform(1.3, 3.0) * self.pitch

    @property
    def duration(self) -> float:
        return 2 * self.reach / float(np.min(self.speed)) + (0 if self.kind == "straight" else self.dwell)

    def places(self, time: float) -> FloatArray:
        """(fingers, 2) [m], from the middle of the skin."""
        way = -self.reach + self.speed * time * np.ones(len(self.ahead))
        if self.kind != "straight":
            after = time - (self.stop + self.reach) / self.speed - self.dwell
            onward = self.stop + self.speed * after * (1 if self.kind == "pause" else -1)
            way = np.minimum(way, self.stop) if after < 0 else onward * np.ones(len(way))
        return way[:, None] * self.ahead + self.aside

    def same_ids_after(self, *, noise: float = 0.0, seed: int = 0) -> bool | None:
        """Whether each finger has its id again after a merge of all; None without a merge or without parting."""
        map_ = map_of(self.pitch)
        random = np.random.default_rng(seed)
        taxels = map_.skin.patches[0].taxels
        detector = ContactDetector(map_)
        at = taxels.positions[:, :2] - SIDE * self.pitch / 2
        first = None
        last = None
        merged = False
        for step in range(int(self.duration * self.rate)):
            places = self.places(step / self.rate)
            pressures = random.normal(0, noise, len(at))
            for place, force in zip(places, self.forces, strict=True):
                shape = np.maximum(1 - ((at - place) ** 2).sum(axis=1) / self.radius**2, 0)
                pressures += force * shape / max(float(shape @ taxels.areas), 1e-12)
            regions = detector.read(pressures, time=step / self.rate)
            if len(regions) < len(places):
                merged = merged or first is not None
                last = None
                continue
            centres = np.array([region.link_position[:2] for region in regions]) - SIDE * self.pitch / 2
            own = [int(np.linalg.norm(centres - place, axis=1).argmin()) for place in places]
            last = [regions[number].id for number in own] if len(set(own)) == len(own) else None
            first = first or last
        return last == first if merged and last else None


def right(kind: str, runs: int, *, ratio: float, count: int = 2, noise: float = 0.0) -> tuple[int, int]:
    """Return the number of correct runs and the number of runs with a merge."""
    found = [Fingers(kind, seed, ratio=ratio, count=count).same_ids_after(noise=noise) for seed in range(runs)]
    counted = [one for one in found if one is not None]
    assert len(counted) > 0.4 * runs
    return sum(counted), len(counted)


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("kind", "ratio"), [("straight", 1.0), ("pause", 1.0), ("back", 1.3)])
@pytest.mark.parametrize("count", [2, 3])
def test_contacts_keep_their_ids_through_a_merge(kind: str, ratio: float, count: int) -> None:
    same, of = right(kind, 4, ratio=ratio, count=count)
    assert same == of


@pytest.mark.long
@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("noise", [0.0, 150.0])
@pytest.mark.parametrize(
    ("kind", "ratio"),
    [("straight", 1.0), ("straight", 1.3), ("pause", 1.0), ("pause", 1.3), ("back", 1.3)],
)
def test_95_percent_of_crossings_are_identified(kind: str, ratio: float, noise: float, count: int) -> None:
    same, of = right(kind, 60, ratio=ratio, count=count, noise=noise)
    assert same >= 0.95 * of


def test_equal_contacts_that_turn_back_cannot_be_distinguished_from_those_that_cross() -> None:
    same, of = right("back", 5, ratio=1.0)
    assert same < 0.5 * of
