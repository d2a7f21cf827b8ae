"""Position, uncertainty and ellipse of the centre of pressure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.centre_of_pressure import (
    BackProjector,
    ContactLocation,
    SensorUncertainty,
    principal_axes,
)
from tactile_maps.core.errors import MapError
from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import MapDocument
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.layout import MapLayout
from tactile_maps.skin.model.skin import Skin
from tests.support.touch import arm


@pytest.mark.parametrize("name", ["noise", "gain", "calibration", "lag", "elapsed"])
@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_invalid_deviation_is_rejected(name, value):
    with pytest.raises(MapError, match=name):
        SensorUncertainty(**{name: value})


MAP = arm().map
SKIN = MAP.skin


def test_map_point_is_located_on_the_body_by_its_containing_triangle():
    placer = BackProjector(MAP, SKIN.positions)
    random = np.random.default_rng(0)
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
        assert place.link_position == pytest.approx(SKIN.position(place.at), abs=1e-12)
        assert place.link_normal == pytest.approx(SKIN.normal(place.at), abs=1e-12)
        assert place.link_position == pytest.approx(SKIN.position(at), abs=1e-9)


def test_walk_continues_after_meeting_a_border():
    """The walk starts at the farthest triangle of the patch, from which the straight line may leave the map."""
    placer = BackProjector(MAP, SKIN.positions)
    for taxel in range(0, len(SKIN), 17):
        patch = int(SKIN.patch_of[taxel])
        centre = MAP.taxel_points[taxel]
        faces = MAP.charts[patch].faces
        far = int(np.linalg.norm(MAP.uv[patch][faces].mean(axis=1) - centre, axis=1).argmax())
        place = placer.place(patch, centre, near=far)
        assert place is not None
        assert SKIN.position(place.at) == pytest.approx(SKIN.positions[taxel], abs=1e-9)


def test_point_outside_its_patch_has_no_position_even_on_another_patch():
    placer = BackProjector(MAP, SKIN.positions)
    other = MAP.taxel_points[int(SKIN.first[1])]
    assert MAP.to_body(other).patch == 1
    assert placer.place(0, other, near=0) is None


def test_edited_map_locates_points_by_its_new_layout():
    placer = BackProjector(MAP, SKIN.positions)
    placer.place(0, MAP.taxel_points[0], near=placer.face_of(0))
    moved = move(MapDocument.of(MAP), [0], (0.3, 0.0)).map
    placer.use(moved)
    place = placer.place(0, moved.taxel_points[0], near=placer.face_of(0))
    assert place.link_position == pytest.approx(SKIN.positions[0], abs=1e-9)
    first, *rest = moved.layout.placements
    large = replace(moved, layout=MapLayout((replace(first, scale=2 * first.scale), *rest)))
    placer.use(large)
    larger = placer.place(0, large.taxel_points[0], near=placer.face_of(0))
    assert larger.at.face == place.at.face
    assert larger.map_sides == pytest.approx(2 * place.map_sides), "of the map in use"
    cut = replace(MAP.charts[0], faces=MAP.charts[0].faces[:, [1, 2, 0]])
    turned = replace(MAP, charts=(cut, *MAP.charts[1:]))
    placer.use(turned)
    assert 0 not in placer._walks, "another cut has other ways"


def test_empty_skin_has_no_positions():
    assert Skin(()).positions.shape == (0, 3)


AT = SurfacePoint(0, 0, (1.0, 0.0, 0.0))


def flat(*, map_sides=((1.0, 0.0), (0.0, 1.0)), normal=(0.0, 0.0, 1.0), sides=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))):
    zero = np.zeros(3)
    return ContactLocation(AT, np.zeros(2), zero, np.array(normal), np.array(sides), np.array(map_sides), False)


def ellipse(long: float, short: float, angle: float, count: int = 20_000) -> np.ndarray:
    """Points spread evenly over an ellipse in the plane z = 0."""
    random = np.random.default_rng(0)
    turn = random.uniform(0, 2 * np.pi, count)
    reach = np.sqrt(random.uniform(0, 1, count))
    x = long * reach * np.cos(turn)
    y = short * reach * np.sin(turn)
    c = np.cos(angle)
    s = np.sin(angle)
    return np.stack([c * x - s * y, s * x + c * y, 0 * x], axis=1)


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.5, -1.0])
def test_uniformly_pressed_ellipse_is_recovered(angle):
    points = ellipse(0.03, 0.01, angle)
    axes, on_map = principal_axes(points, np.full(len(points), 1 / len(points)), 0.0, flat())
    assert np.linalg.norm(axes, axis=1) == pytest.approx([0.03, 0.01], rel=0.02)
    assert abs(axes[0] @ [np.cos(angle), np.sin(angle), 0]) == pytest.approx(0.03, rel=0.02)
    assert axes[0] @ axes[1] == pytest.approx(0, abs=1e-15)
    assert on_map == pytest.approx(axes[:, :2])


def test_ellipse_of_one_taxel_has_its_area():
    axes, _ = principal_axes(np.zeros((1, 3)), np.ones(1), 1e-4 / 12, flat())
    assert np.linalg.norm(axes, axis=1) == pytest.approx(2 * np.sqrt(1e-4 / 12))


def test_axes_follow_the_stretch_of_the_map():
    points = ellipse(0.03, 0.01, 0.0)
    share = np.full(20_000, 1 / 20_000)
    _, on_map = principal_axes(points, share, 0.0, flat(map_sides=((2.0, 0.0), (0.0, 0.5))))
    assert np.linalg.norm(on_map, axis=1) == pytest.approx([0.06, 0.005], rel=0.02)


def test_degenerate_triangle_gives_no_axes():
    points = ellipse(0.03, 0.01, 0.0)
    share = np.full(20_000, 1 / 20_000)
    axes, on_map = principal_axes(points, share, 0.0, flat(sides=((1.0, 0.0, 0.0), (2.0, 0.0, 0.0))))
    assert np.linalg.norm(axes[0]) == pytest.approx(0.03, rel=0.02)
    assert not on_map.any()


@pytest.mark.parametrize("side", [(0.0, 0.0, 1.0), (0.0, 0.0, 0.0)])
def test_triangle_side_along_the_normal_still_gives_axes(side):
    points = ellipse(0.03, 0.01, 0.0)
    share = np.full(20_000, 1 / 20_000)
    axes, _ = principal_axes(points, share, 0.0, flat(sides=(side, (0.0, 1.0, 0.0))))
    assert np.linalg.norm(axes, axis=1) == pytest.approx([0.03, 0.01], rel=0.02)
    x = principal_axes(points[:, [2, 0, 1]], share, 0.0, flat(sides=((1.0, 0, 0), (0, 1.0, 0)), normal=(1.0, 0, 0)))[0]
    assert np.linalg.norm(x, axis=1) == pytest.approx([0.03, 0.01], rel=0.02)
