"""In space first, then in the plane."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.distance import pdist, squareform

from app.maps.learned.geodesic_information import build, in_space, in_units_of_near, through_space
from app.maps.learned.learned_map import silent
from app.touch.babbling import BabbleSpec, babble
from tests.numerics.map_surfaces import frustum, skin_of


@pytest.fixture(scope="module")
def tube():
    return skin_of(frustum(0.04, 0.04, length=0.16), taxels=160)


def test_taxels_of_a_sheet_lie_where_they_lie(touched_sheet, misfit):
    learned = build(touched_sheet[1])
    assert learned.method == "geodesic-information"
    assert "no-learned-surface" not in [finding.kind for finding in learned.findings]
    assert misfit(learned.points) < 0.5


def test_the_unit_is_what_is_near_for_both_ends():
    unlike = np.array([[0.0, 2, 4], [2, 0, np.inf], [4, np.inf, 0]])
    scaled = in_units_of_near(unlike, neighbours=2)
    # Near is 4 for the first and third, and for the second, which knows one neighbour only, 2.
    assert np.allclose(scaled, [[0, 2 / np.sqrt(8), 1], [2 / np.sqrt(8), 0, np.inf], [1, np.inf, 0]])


def test_a_coarse_part_is_not_pushed_away():
    unlike = np.array([[0.0, 1, 2], [1, 0, 2], [2, 2, 0]])
    assert np.allclose(in_units_of_near(unlike), in_units_of_near(5 * unlike))


def test_points_of_space_are_found_again():
    truth = np.random.default_rng(12).normal(size=(30, 3))
    assert np.allclose(pdist(in_space(squareform(pdist(truth)))), pdist(truth), atol=1e-6)


def test_a_tube_is_opened(tube):
    learned = build(babble(tube, BabbleSpec(touches=2000)))
    assert "opened" in [finding.kind for finding in learned.findings]
    near = squareform(pdist(learned.points)) + np.diag(np.full(160, np.inf))
    truth = squareform(pdist(tube.patches[0].taxels.positions)) + np.diag(np.full(160, np.inf))
    kept = [len(np.intersect1d(a[:6], b[:6])) for a, b in zip(near.argsort(1), truth.argsort(1), strict=True)]
    assert np.mean(kept) > 0.75 * 6, "crushed into the plane it keeps half"


def test_without_a_surface_it_goes_straight_to_the_plane():
    line = squareform(pdist(np.arange(12.0)[:, None]))
    points, (note,) = through_space(line, silent)
    assert note.kind == "no-learned-surface"
    assert np.allclose(pdist(points), pdist(np.arange(12.0)[:, None]), atol=1e-6)
