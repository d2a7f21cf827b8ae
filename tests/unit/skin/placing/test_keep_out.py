"""Zones: whatever of a face may lie in one is kept out, and not much more."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import SkinError
from app.skin.placement_spec import Ball, BorderStrip, Box, Painted
from app.skin.placing.keep_out import allowed_faces
from tests.numerics.map_surfaces import sheet, sphere

SHEET = sheet(24, 16)
CORNERS = SHEET.vertices[SHEET.faces]
MIDDLES = CORNERS.mean(axis=1)
EDGE = float(np.linalg.norm(np.ptp(CORNERS, axis=1), axis=1).max())
SHARES = np.random.default_rng(0).dirichlet(np.ones(3), 300)
SAMPLES = np.einsum("sc,mcd->msd", SHARES, CORNERS)  # many points of each face


@pytest.mark.parametrize("height", [0.0, 0.006])
@pytest.mark.parametrize("radius", [0.001, 0.01, 0.03])
def test_a_ball(radius, height):
    centre = np.array([0.0511, 0.0377, height])
    kept = allowed_faces(SHEET, [Ball(centre, radius)])
    away = np.linalg.norm(SAMPLES - centre, axis=2).min(axis=1)
    assert not kept[away < radius].any()
    assert kept[away > radius + 0.2 * EDGE].all()


def test_a_ball_smaller_than_a_face_still_takes_it():
    assert (~allowed_faces(SHEET, [Ball(MIDDLES[100], 1e-6)])).sum() == 1


def test_a_box():
    low, high = np.array([0.02, 0.03, -1.0]), np.array([0.0601, 0.05, 1.0])
    kept = allowed_faces(SHEET, [Box(low, high)])
    points, middles = SAMPLES, CORNERS.mean(axis=1)
    touched = ((low < points) & (points < high)).all(axis=2).any(axis=1)
    assert touched.any()
    assert not kept[touched].any()
    assert kept[((middles < low - EDGE) | (middles > high + EDGE)).any(axis=1)].all()


def test_a_strip_along_the_border():
    kept = allowed_faces(SHEET, [BorderStrip(0.0149)])
    edge = np.minimum(CORNERS[:, :, :2], [0.12, 0.08] - CORNERS[:, :, :2]).min(axis=(1, 2))
    assert np.array_equal(kept, edge >= 0.0149)


def test_a_closed_surface_has_no_border_to_keep_from():
    assert allowed_faces(sphere(), [BorderStrip(0.5)]).all()


def test_paint():
    marked = np.zeros(len(SHEET.vertices), dtype=bool)
    marked[30] = True
    kept = allowed_faces(SHEET, [Painted(marked)])
    assert np.array_equal(~kept, (SHEET.faces == 30).any(axis=1))
    with pytest.raises(SkinError, match="one mark for each vertex"):
        allowed_faces(SHEET, [Painted(marked[1:])])


def test_zones_add_up_and_may_not_take_all():
    one, other = Ball(MIDDLES[0], 0.01), Ball(MIDDLES[-1], 0.02)
    both = allowed_faces(SHEET, [one, other])
    assert np.array_equal(both, allowed_faces(SHEET, [one]) & allowed_faces(SHEET, [other]))
    with pytest.raises(SkinError, match="nothing of the surface is left"):
        allowed_faces(SHEET, [Ball(np.zeros(3), 1.0)])
