"""A map that is cut where the skin is touched: as good a map, of the same skin, with seams across the path."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.path_following.surface_path import SurfacePath
from tactile_maps.maps.evaluation.quality import measure
from tactile_maps.maps.model.seam_transitions import SeamTransitions
from tactile_maps.maps.paths import path_about
from tactile_maps.studies.path_time.body_path import touched_place
from tactile_maps.studies.testbeds.fixed_ball import with_fixed_ball
from tactile_maps.studies.testbeds.slit_map import with_slits
from tests.support.pressed_arm import forearm


@pytest.fixture(scope="module")
def prepared():
    return with_fixed_ball(forearm(), taxel=150)


def seams_near(prepared, place, within):
    """Middles (k, 3) of the cut edges of the body within a distance of a place [m]."""
    map_ = prepared.map
    transitions = SeamTransitions(map_)
    borders = transitions.borders
    inner = np.flatnonzero(borders.partner >= 0)
    surface = prepared.skin.patches[place.patch].surface
    faces = borders.face[inner]
    sides = borders.side[inner]
    ends = np.stack([surface.faces[faces, sides], surface.faces[faces, (sides + 1) % 3]], axis=1)
    middles = surface.vertices[ends].mean(axis=1)
    return middles[np.linalg.norm(middles - prepared.skin.position(place), axis=1) < within]


def test_map_without_cuts_is_unchanged(prepared):
    assert with_slits(prepared, touched_place(prepared), 0) is prepared


@pytest.mark.sampled(1)
@pytest.mark.parametrize("count", [1, 2, 3])
def test_path_about_the_place_crosses_the_cuts_and_returns(prepared, count):
    place = touched_place(prepared)
    assert not len(seams_near(prepared, place, 0.015))
    cut = with_slits(prepared, place, count)
    assert len(seams_near(cut, place, 0.015)) >= count
    assert cut.map.skin is prepared.skin
    assert measure(cut.map).bijective
    drawn = path_about("lemniscate", cut.map.to_map(place), 0.03)
    path = SurfacePath(drawn, SeamTransitions(cut.map), drawn=False)
    assert path.whole
    assert path.closed
    assert not path.crossings
    assert len(path.points_on_map) > 2 * count  # split where it continues behind a seam
    # The same way on the body as without cuts, but for what the map stretches.
    whole = SurfacePath(path_about("lemniscate", prepared.map.to_map(place), 0.03), SeamTransitions(prepared.map))
    reach = [
        np.ptp([prepared.skin.position(one.at(way)[0]) for way in np.linspace(0, one.length, 60)[:-1]], axis=0)
        for one in (path, whole)
    ]
    assert np.linalg.norm(reach[0]) == pytest.approx(np.linalg.norm(reach[1]), rel=0.1)
