"""Normals of taxels: those of the surface they were taken from, whatever the file says."""

from __future__ import annotations

import numpy as np
import pytest

from app.skin.normals import estimate_normals
from app.skin.place import place_taxels
from tests.numerics.map_surfaces import cap, frustum, sheet, sphere


def _taxels(surface, count=250):
    taxels = place_taxels(surface, min(count, len(surface.faces) // 3))
    return taxels.positions, taxels.normals


def _agreement(found, true):
    return (found.normals * true).sum(axis=1)


@pytest.mark.parametrize(
    "surface", [sphere(), frustum(), frustum(0.05, 0.02), cap(1.2)], ids=["ball", "tube", "cone", "cap"]
)
def test_a_bent_surface_shows_its_outside_by_itself(surface):
    positions, true = _taxels(surface)
    found = estimate_normals(positions + 1.0)
    assert np.quantile(_agreement(found, true), 0.05) > np.cos(0.3)
    assert (_agreement(found, true) > 0).all()
    assert not found.findings
    assert np.linalg.norm(found.normals, axis=1) == pytest.approx(1)


def test_stated_normals_choose_the_side_and_no_more():
    positions, true = _taxels(sphere())
    tilted = -true + 0.5 * np.array([0, 0, 1.0])
    tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
    inward = estimate_normals(positions, stated=tilted)
    assert np.array_equal(inward.normals, -estimate_normals(positions).normals)
    assert not inward.findings


def test_a_few_wrong_ones_are_outvoted():
    positions, true = _taxels(sheet(shape=lambda x, y: 2 * x * y))
    stated = np.where(np.arange(len(true))[:, None] % 5 == 0, -true, true)
    assert (_agreement(estimate_normals(positions, stated=stated), true) > 0).all()


@pytest.mark.parametrize(
    ("stated", "kind"),
    [
        (lambda true: np.zeros_like(true), "dummy-normals"),
        (lambda true: np.tile([0.0, 0.0, 1.0], (len(true), 1)), "dummy-normals"),
        (lambda true: np.roll(true, 1, axis=1), "foreign-normals"),
    ],
    ids=["zero", "one for all", "another frame"],
)
def test_normals_that_mean_nothing_are_told_and_left(stated, kind):
    positions, true = _taxels(frustum())
    found = estimate_normals(positions, stated=stated(true))
    assert [note.kind for note in found.findings] == [kind]
    assert np.array_equal(found.normals, estimate_normals(positions).normals)


def test_one_normal_for_all_is_right_on_a_plane():
    positions, _ = _taxels(sheet())
    down = estimate_normals(positions, stated=np.tile([0.0, 0.0, -1.0], (len(positions), 1)))
    assert not down.findings
    assert down.normals == pytest.approx(np.tile([0, 0, -1.0], (len(positions), 1)), abs=1e-9)


def test_a_plane_far_from_the_link_looks_away_from_it_and_says_it_guesses():
    positions, _ = _taxels(sheet())
    for lift in (0.1, -0.1):
        found = estimate_normals(positions + [0, 0, lift])
        assert (found.normals[:, 2] * lift > 0).all()
        assert [note.kind for note in found.findings] == ["guessed-outside"]


def test_sheets_apart_are_each_judged():
    near, _ = _taxels(sheet(), 60)
    two = np.concatenate([near + [0, 0, 0.2], near - [0, 0, 0.2]])
    assert np.array_equal(np.sign(estimate_normals(two).normals[:, 2]), np.repeat([1, -1], len(near)))


@pytest.mark.parametrize("count", [1, 2, 3, 9])
def test_a_row_has_normals_square_to_it_and_outward(count):
    row = np.stack([0.01 * np.arange(count), np.zeros(count), np.full(count, 0.05)], axis=1)
    found = estimate_normals(row)
    assert found.straight.all()
    assert np.linalg.norm(found.normals, axis=1) == pytest.approx(1)
    assert (found.normals[:, 2] > 0).all()
    if count > 1:
        assert found.normals[:, 0] == pytest.approx(0, abs=1e-9)


def test_a_row_believes_what_is_stated():
    row = np.stack([0.01 * np.arange(5), np.zeros(5), np.full(5, 0.05)], axis=1)
    stated = np.tile([0.0, 1.0, 0.0], (5, 1))
    assert estimate_normals(row, stated=stated).normals == pytest.approx(stated)
