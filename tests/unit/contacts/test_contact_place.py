"""Places of centres of pressure: exact on map and body, within their own patch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.contacts.place import Placer, body_of
from app.editing.arrange import move
from app.editing.document import MapDocument
from app.skin.skin import Skin
from tests.touch import arm

MAP = arm().map
SKIN = MAP.skin


def test_a_map_point_is_put_on_the_body_by_its_containing_triangle():
    placer, random = Placer(MAP, body_of(SKIN)), np.random.default_rng(0)
    for taxel in range(0, len(SKIN), 9):
        patch = int(SKIN.patch_of[taxel])
        centre = MAP.taxel_points[taxel] + random.normal(0, 1e-3, 2)
        place = placer.place(patch, centre, near=placer.face_of(taxel))
        at = MAP.to_body(centre)
        if at is None:
            assert place is None
            continue
        assert place is not None
        assert not place.torn
        assert place.at.patch == patch
        assert MAP.to_map(place.at) == pytest.approx(centre, abs=1e-12)
        assert place.point == pytest.approx(SKIN.position(place.at), abs=1e-12)
        assert place.normal == pytest.approx(SKIN.normal(place.at), abs=1e-12)
        assert place.point == pytest.approx(SKIN.position(at), abs=1e-9)


def test_a_walk_that_meets_a_border_is_no_end():
    """From the farthest triangle of the patch, whose straight way may leave the map."""
    placer = Placer(MAP, body_of(SKIN))
    for taxel in range(0, len(SKIN), 17):
        patch, centre = int(SKIN.patch_of[taxel]), MAP.taxel_points[taxel]
        faces = MAP.charts[patch].faces
        far = int(np.linalg.norm(MAP.uv[patch][faces].mean(axis=1) - centre, axis=1).argmax())
        place = placer.place(patch, centre, near=far)
        assert place is not None
        assert SKIN.position(place.at) == pytest.approx(body_of(SKIN)[taxel], abs=1e-9)


def test_outside_its_patch_there_is_no_place_even_over_another_patch():
    placer = Placer(MAP, body_of(SKIN))
    other = MAP.taxel_points[int(SKIN.first[1])]
    assert MAP.to_body(other).patch == 1
    assert placer.place(0, other, near=0) is None


def test_a_point_of_the_body_is_put_back_on_the_skin():
    placer = Placer(MAP, body_of(SKIN))
    at = SKIN.taxel_point(40)
    place = placer.put_back(at.patch, SKIN.position(at) + 1e-3 * SKIN.normal(at))
    assert place.torn
    assert np.linalg.norm(place.point - SKIN.position(at)) < 1e-3
    assert place.map_point == pytest.approx(MAP.to_map(place.at), abs=1e-12)


def test_an_edited_map_places_by_the_edit():
    placer = Placer(MAP, body_of(SKIN))
    placer.place(0, MAP.taxel_points[0], near=placer.face_of(0))
    moved = move(MapDocument.of(MAP), [0], (0.3, 0.0)).map
    placer.use(moved)
    place = placer.place(0, moved.taxel_points[0], near=placer.face_of(0))
    assert place.point == pytest.approx(body_of(SKIN)[0], abs=1e-9)
    cut = replace(MAP.charts[0], faces=MAP.charts[0].faces[:, [1, 2, 0]])
    turned = replace(MAP, charts=(cut, *MAP.charts[1:]))
    placer.use(turned)
    assert 0 not in placer._walks, "another cut has other ways"


def test_no_skin_has_no_positions():
    assert body_of(Skin(())).shape == (0, 3)
