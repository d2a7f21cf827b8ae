"""Swapped channels of a module are found by their neighbours, and none where nothing is swapped or felt."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactile_maps.live.channels.channel_swaps import SwapDetector
from tactile_maps.skin.model.skin import Skin, TaxelIdentity
from tactile_maps.studies.testbeds.reference_bodies import flat_map

SIDE = 12
COUNT = 144
PLACES = np.stack(np.divmod(np.arange(COUNT), SIDE), axis=1)
MODULES = (PLACES[:, 0] // 3) * 3 + PLACES[:, 1] // 4


@cache
def skin(*, modules=True):
    (patch,) = flat_map(COUNT).skin.patches
    identity = TaxelIdentity(modules=MODULES, channels=np.arange(COUNT)) if modules else TaxelIdentity()
    return Skin((replace(patch, taxels=replace(patch.taxels, identity=identity)),))


def found(order, *, touches=500, seed=0, modules=True):
    """Return the swaps found in readings with channels in this order: round touches, wrong gains, noise."""
    random = np.random.default_rng(seed)
    detector = SwapDetector(skin(modules=modules))
    gains = 40 * (1 + 0.15 * random.normal(size=COUNT))
    for number in range(touches):
        away = ((PLACES - random.uniform(0, SIDE - 1, 2)) ** 2).sum(axis=1)
        pressed = gains * np.clip(1 - away / 4, 0, None)
        for step, share in enumerate((0.0, 0.6, 1.0, 0.4, 0.0)):
            values = np.rint(20 + share * pressed + 0.7 * random.normal(size=COUNT))
            detector.add(values[order], 0.5 * number + 0.1 * step)
    return detector.swapped


def swapped(*pairs):
    order = np.arange(COUNT)
    for one, other in pairs:
        order[[one, other]] = order[[other, one]]
    return order


PAIRS = ((13, 27), (41, 64))


def test_only_swapped_pairs_of_a_module_are_found():
    swaps = found(swapped(*PAIRS))
    assert [(one.first, one.second, one.module) for one in swaps] == [(13, 27, 0), (41, 64, MODULES[41])]
    assert all(one.strength > 0.2 for one in swaps)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("seed", range(2))
def test_no_swap_is_reported_for_channels_in_order(seed):
    assert found(np.arange(COUNT), seed=seed) == ()


def test_too_few_touches_report_no_swap():
    assert found(swapped(*PAIRS), touches=15) == ()


@pytest.mark.long
def test_nearby_taxels_are_compared_on_skins_without_modules():
    (one,) = found(swapped((64, 66)), modules=False)
    assert (one.first, one.second, one.module) == (64, 66, None)


def test_resting_finger_and_drift_report_no_swap():
    detector = SwapDetector(skin())
    random = np.random.default_rng(0)
    for number in range(600):
        detector.add(20 + 0.01 * number + 30 * (MODULES == 4) + random.normal(size=COUNT), 0.1 * number)
    assert detector.swapped == ()
