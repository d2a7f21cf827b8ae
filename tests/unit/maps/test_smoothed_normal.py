"""The normal that two rings of taxels tell: right where the skin is simple, and forgiving of misplaced taxels."""

from __future__ import annotations

import numpy as np
import pytest

from app.geometry.surface_point import SurfacePoint
from app.maps.build import build_map
from app.maps.layout import MapLayout, Placement
from app.maps.map_jacobian import MapJacobian
from app.maps.tactile_map import TactileMap
from app.skin.misplace import misplaced
from app.skin.skin import Skin
from tests.touch import arm, bar_skin, prepared_bar


def turned(one, other) -> float:
    """Between two unit vectors [degrees]."""
    return float(np.degrees(np.arccos(np.clip(one @ other, -1.0, 1.0))))


def test_on_a_plane_it_is_the_plane_s():
    map_ = prepared_bar().map
    for face in range(0, len(map_.skin.patches[0].surface.faces), 37):
        normal = MapJacobian(map_).normal(SurfacePoint(0, face, (0.2, 0.3, 0.5)))
        assert normal == pytest.approx([0, 0, 1], abs=1e-9)


def test_how_the_patch_is_drawn_makes_no_difference():
    map_ = prepared_bar().map
    drawn = TactileMap(map_.skin, map_.charts, MapLayout((Placement(angle=0.7, scale=3.0),)))
    at = map_.skin.taxel_point(25)
    assert MapJacobian(drawn).normal(at) == pytest.approx(MapJacobian(map_).normal(at), abs=1e-9)


def test_on_a_bent_skin_it_follows_the_surface_between_the_taxels():
    map_, skin = arm().map, arm().skin
    jacobian, off = MapJacobian(map_), []
    for taxel in range(0, len(skin), 3):
        at = skin.taxel_point(taxel)
        off.append(turned(jacobian.normal(at), skin.normal(at)))
    assert np.median(off) < 4.0
    assert np.percentile(off, 95) < 10.0, "at a pitch of 30 mm on links of 36 mm: two rings would be off by 14"


@pytest.mark.parametrize(("sd", "least"), [(0.001, 2.5), (0.002, 2.5), (0.004, 2.0)])
def test_misplaced_taxels_turn_triangles_and_hardly_the_smoothed_normal(sd, least):
    """On a plane at a pitch of 9 mm, where the truth is known."""
    believed = build_map(misplaced(bar_skin(500, finer=3), sd, seed=1))
    jacobian, triangle, smooth = MapJacobian(believed), [], []
    for taxel in range(0, 500, 7):
        at = believed.skin.taxel_point(taxel)
        triangle.append(turned(believed.skin.normal(at), np.array([0.0, 0.0, 1.0])))
        smooth.append(turned(jacobian.normal(at), np.array([0.0, 0.0, 1.0])))
    assert np.median(triangle) > 4e3 * sd, "degrees: the triangles are spoilt"
    assert np.median(smooth) < np.median(triangle) / least
    assert np.percentile(smooth, 95) < np.percentile(triangle, 95) / least


def test_it_is_of_length_one():
    map_ = arm().map
    jacobian = MapJacobian(map_)
    for taxel in range(0, len(map_.skin), 11):
        assert np.linalg.norm(jacobian.normal(map_.skin.taxel_point(taxel))) == pytest.approx(1.0, abs=1e-12)


def test_too_few_taxels_tell_none():
    skin = bar_skin(3)
    assert len(skin) < 4
    assert MapJacobian(build_map(Skin(skin.patches))).normal(SurfacePoint(0, 0, (1.0, 0.0, 0.0))) is None
