"""SMACOF: never up, exact where possible, and where not as good as a general optimiser."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.distance import cdist, pdist, squareform

from app.maps.learned.smacof import kruskal_stress, smacof


@pytest.fixture(scope="module")
def drawn():
    generator = np.random.default_rng(6)
    return generator.normal(size=(25, 3)), generator.normal(size=(25, 2))


def test_the_loss_never_rises(drawn):
    ball, start = drawn
    losses = np.array(smacof(squareform(pdist(ball)), start).losses)
    assert len(losses) > 10
    assert (np.diff(losses) <= 0).all()
    assert losses[-1] < 0.5 * losses[0]


def test_points_of_the_plane_are_found_again(drawn):
    _, plane = drawn
    wanted = squareform(pdist(plane))
    near = plane + 0.1 * np.random.default_rng(7).normal(size=plane.shape)
    fitted = smacof(wanted, near, rounds=5000, tolerance=1e-12)
    assert cdist(fitted.points, fitted.points) == pytest.approx(wanted, abs=1e-4)
    assert kruskal_stress(fitted.points, wanted) < 1e-5


def test_a_general_optimiser_finds_nothing_better(drawn):
    ball, start = drawn
    wanted = pdist(ball)

    def loss(flat):
        return ((pdist(flat.reshape(-1, 2)) / wanted - 1) ** 2).sum()

    ours = smacof(squareform(wanted), start, rounds=5000, tolerance=1e-12).points
    better = minimize(loss, ours.ravel(), method="BFGS")
    assert loss(ours.ravel()) <= better.fun * (1 + 1e-5)


def test_points_on_one_place_part(drawn):
    start = drawn[1].copy()
    start[1] = start[0]
    assert np.isfinite(smacof(squareform(pdist(drawn[0])), start).points).all()


def test_stress_knows_no_scale(drawn):
    ball, plane = drawn
    wanted = squareform(pdist(ball))
    stress = kruskal_stress(plane, wanted)
    assert 0.1 < stress < 1
    assert kruskal_stress(7 * plane, wanted) == pytest.approx(stress)
    assert np.isnan(kruskal_stress(0 * plane, wanted))
    scales = np.linspace(0.1, 3, 3000)[:, None, None]
    tried = np.sqrt(((scales * squareform(pdist(plane)) - wanted) ** 2).sum(axis=(1, 2)) / (wanted**2).sum())
    assert stress == pytest.approx(tried.min(), rel=1e-5)


def test_progress_may_cancel(drawn):
    def cancel(_text, _fraction):
        raise InterruptedError

    with pytest.raises(InterruptedError):
        smacof(squareform(pdist(drawn[0])), drawn[1], progress=cancel)
