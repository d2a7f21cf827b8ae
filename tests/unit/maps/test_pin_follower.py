"""The map under the hand, whole or carried: pins followed, energy down, and the same end both ways."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.maps.bijective import flipped
from app.maps.methods.disk import Disk
from app.maps.pin_follower import PinFollower
from app.maps.proxy import build_proxy
from tests.unit.maps.pinned_patches import far_points, waves


@pytest.fixture(params=["whole", "by a stand-in"])
def follower(request):
    surface, chart = waves()
    unit = np.sqrt(surface.area)
    plane = chart.plane / unit
    disk = Disk((surface.vertices - surface.vertices.mean(axis=0))[chart.vertex_of] / unit, chart.faces)
    proxy = build_proxy(surface, replace(chart, plane=plane), faces=700) if request.param != "whole" else None
    return PinFollower(disk.energy, plane, proxy=proxy), chart, plane


def held(chart, plane):
    corners = chart.faces[[int(np.flatnonzero((chart.faces == v).any(axis=1))[0]) for v in far_points(plane, 4)]]
    weights = np.tile([0.2, 0.3, 0.5], (4, 1))
    return corners, weights, np.einsum("pc,pcd->pd", weights, plane[corners])


def test_without_pins_it_is_still(follower):
    moving, _, plane = follower
    assert moving.still
    np.testing.assert_allclose(moving.plane, plane, atol=1e-12)


def test_it_follows_and_comes_to_rest(follower):
    moving, chart, plane = follower
    corners, weights, places = held(chart, plane)
    moving.pin(corners, weights, places)
    assert not moving.still
    moving.aim(places + [[0.1, 0.05], [0, 0], [0, 0], [0, 0]])
    before = moving.energy
    for _ in range(60):
        moving.frame()
        assert moving.energy <= before
        assert not flipped(moving.plane, chart.faces).any()
        before = moving.energy
        if moving.still:
            break
    assert moving.still
    there = np.einsum("pc,pcd->pd", weights, moving.plane[corners])
    np.testing.assert_allclose(there, places + [[0.1, 0.05], [0, 0], [0, 0], [0, 0]], atol=2e-3)


def test_whole_and_carried_agree():
    surface, chart = waves()
    unit = np.sqrt(surface.area)
    plane = chart.plane / unit
    disk = Disk((surface.vertices - surface.vertices.mean(axis=0))[chart.vertex_of] / unit, chart.faces)
    both = [
        PinFollower(disk.energy, plane),
        PinFollower(disk.energy, plane, proxy=build_proxy(surface, replace(chart, plane=plane), faces=700)),
    ]
    corners, weights, places = held(chart, plane)
    for moving in both:
        moving.pin(corners, weights, places + [[0.1, 0.05], [0, 0], [0, 0], [0, 0]])
        for _ in range(20):
            moving.frame()
    assert both[0].energy > disk.energy.energy(plane) + 0.02, "the pull costs something"
    assert both[0].energy <= both[1].energy < both[0].energy + 0.05
    assert np.abs(both[0].plane - both[1].plane).max() < 0.02


def test_a_small_patch_catches_up_within_a_frame(follower):
    moving, chart, plane = follower
    corners, weights, places = held(chart, plane)
    moving.pin(corners, weights, places)
    moving.aim(places + 0.08)
    moving.frame()
    gone = np.einsum("pc,pcd->pd", weights, moving.plane[corners]) - places
    assert (gone > 0.05).all()
