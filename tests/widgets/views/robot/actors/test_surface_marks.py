"""Ribbons, heads and diamonds on a surface: as wide, as long and as far above it as asked."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_widgets.views.robot.actors.surface_marks import arrowheads, diamonds, ribbon

UP = np.array([0.0, 0.0, 1.0])


def area(triangles):
    return 0.5 * np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)


def line(count):
    points = np.zeros((count, 3))
    points[:, 0] = np.linspace(0, 1, count)
    return points, np.tile(UP, (count, 1))


def test_ribbon_has_its_width_and_the_length_of_its_line():
    made = ribbon(*line(7), 0.02, lift=0.1)
    assert area(made).sum() == pytest.approx(0.02)
    np.testing.assert_allclose(made[..., 2], 0.1)
    np.testing.assert_allclose(np.abs(made[..., 1]), 0.01)


@pytest.mark.parametrize("count", [2, 5, 101])
def test_dashes_do_not_depend_on_the_vertices_of_the_line(count):
    made = ribbon(*line(count), 0.02, lift=0.0, dash=0.1)
    dashes = 6 * 0.1 + min(0.1, 1 - 6 * 0.16)  # each followed by a gap of 0.06
    assert area(made).sum() == pytest.approx(0.02 * dashes)
    x = made[area(made) > 1e-12, :, 0].mean(axis=1)  # where dash and vertex meet there is a sliver of rounding
    assert ((x % 0.16) < 0.1).all()


def test_line_without_length_is_not_drawn():
    assert len(ribbon(*line(1), 0.02, lift=0.1, dash=0.1)) == 0
    points, normals = line(3)
    assert len(ribbon(0 * points, normals, 0.02, lift=0.1)) == 0


def test_diamonds_surround_their_points_at_the_requested_size():
    points = np.eye(3)
    normals = np.tile([[0.6, 0.0, 0.8]], (3, 1))
    made = diamonds(points, normals, np.array([0.1, 0.2, 0.3])).reshape(3, -1, 3)
    away = np.linalg.norm(made - points[:, None], axis=2)
    np.testing.assert_allclose(away, [[half] * 6 for half in (0.1, 0.2, 0.3)])
    np.testing.assert_allclose((made - points[:, None]) @ normals[0], 0, atol=1e-12)


def bent():
    """A line that turns by a right angle."""
    points = np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0, 1, 0]])
    return points, np.tile(UP, (3, 1))


def test_line_has_no_notch_at_a_bend():
    sides = ribbon(*bent(), 0.2, lift=0.0).reshape(2, 6, 3).round(9).tolist()
    first, second = ({tuple(corner) for corner in side} for side in sides)
    assert len(first & second) == 2


def test_sides_of_a_ribbon_may_have_different_widths():
    points, normals = line(4)
    made = ribbon(points, normals, np.array([0.3, 0.2, 0.1]), lift=0.0)
    np.testing.assert_allclose(area(made).reshape(3, 2).sum(axis=1), np.array([0.3, 0.2, 0.1]) / 3)


def test_arrow_heads_point_along_the_line_at_equal_distances():
    points, normals = line(50)
    made = arrowheads(points, normals, 0.05, every=0.3, lift=0.02)
    assert len(made) == 3
    np.testing.assert_allclose(made[:, 1] - made[:, [0, 2]].mean(axis=1), [[0.05, 0, 0]] * 3, atol=1e-12)
    np.testing.assert_allclose(np.diff(made[:, 1, 0]), 0.3)
    np.testing.assert_allclose(made[..., 2], 0.02)
    np.testing.assert_allclose(area(made), 0.5 * 0.05**2)


def test_short_line_has_one_arrow_head_and_a_shorter_one_none():
    points, normals = line(5)
    (head,) = arrowheads(0.2 * points, normals, 0.05, every=0.9, lift=0.0)
    assert 0.05 < head[1, 0] < 0.2
    assert len(arrowheads(0.04 * points, normals, 0.05, every=0.9, lift=0.0)) == 0
