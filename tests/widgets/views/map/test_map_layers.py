"""Iso-lines: on a linear field they are exact, around a disc they are a circle, and they never leave a gap."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from tactile_widgets.views.map.painting.map_layers import contour_segments


def _disc(radius: float) -> np.ndarray:
    rows, columns = np.mgrid[:64, :64]
    return radius - np.hypot(rows - 31.3, columns - 30.8)


def test_contour_of_a_linear_field_is_exact():
    rows, columns = np.mgrid[:20, :30]
    field = 2.0 * columns - 3.0 * rows
    segments = contour_segments(field, 7.5)
    assert len(segments) > 10
    assert 2.0 * segments[..., 0] - 3.0 * segments[..., 1] == pytest.approx(np.full(segments.shape[:2], 7.5))


def test_contour_of_a_disc_is_a_circle():
    segments = contour_segments(_disc(17.0), 0.0)
    radius = np.hypot(segments[..., 1] - 31.3, segments[..., 0] - 30.8)
    assert np.abs(radius - 17.0).max() < 0.02
    length = np.linalg.norm(segments[:, 0] - segments[:, 1], axis=1).sum()
    assert length == pytest.approx(2 * np.pi * 17.0, rel=2e-3)


@pytest.mark.parametrize("seed", range(5))
def test_contours_of_noise_are_closed(seed):
    """Saddles included: inside the image every end meets exactly one other end."""
    field = np.random.default_rng(seed).random((40, 40))
    field[[0, -1]] = field[:, [0, -1]] = 0.0
    ends = contour_segments(field, 0.5).reshape(-1, 2)
    assert len(ends) > 100
    assert set(Counter(map(tuple, np.round(ends, 9))).values()) <= {2, 4}


def test_contour_does_not_depend_on_the_image_size():
    """Only what is around the values above the level is looked at."""
    part = contour_segments(_disc(5.0)[24:40, 22:41], 0.0) + [22, 24]
    np.testing.assert_allclose(contour_segments(_disc(5.0), 0.0), part)


@pytest.mark.parametrize("value", [0.0, 5.0])
def test_constant_field_has_no_contour(value):
    assert contour_segments(np.full((8, 8), value), 1.0).shape == (0, 2, 2)
