"""Pins: what is held stays, what is dragged comes, and the patch around it keeps its place on the map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.editing.arrange import mirror, move, rotate, scale
from tactile_maps.editing.pins import (
    add_pin,
    begin_pin_drag,
    chart_place,
    finish_pin_drag,
    nudge_pins,
    pin_places,
    remove_pins,
    unpin,
    with_dragged_patch,
)
from tactile_maps.editing.reflatten import apply_result, reflatten
from tactile_maps.flattening.bijectivity import crossings, flipped
from tactile_maps.geometry.surface.mesh import SurfacePoint

FIRST = SurfacePoint(1, 4, (0.2, 0.3, 0.5))
SECOND = SurfacePoint(1, 80, (1.0, 0.0, 0.0))


@pytest.fixture(scope="module")
def pinned(document):
    """The sheet, turned, mirrored and enlarged, with two pins."""
    placed = scale(mirror(rotate(move(document, [1], (0.2, 0.1)), [1], 0.6), [1]), [1], 1.5)
    return add_pin(add_pin(placed, FIRST), SECOND)


def _valid(document):
    for chart in document.charts:
        assert not flipped(chart.plane, chart.faces).any()
        assert crossings(chart.plane[chart.border]) == 0
        np.testing.assert_allclose(chart.plane.min(axis=0), 0, atol=1e-12)


def test_adding_a_pin_does_not_change_the_map(document, pinned):
    np.testing.assert_allclose(pin_places(pinned, 1), [pinned.map.to_map(at) for at in (FIRST, SECOND)], atol=1e-12)
    assert all(a is b for a, b in zip(pinned.charts, document.charts, strict=True))
    assert pin_places(document, 1).shape == (0, 2)


def test_pins_move_with_their_patch(pinned):
    turned = rotate(move(pinned, [1], (0.3, 0.0)), [1], 1.0)
    np.testing.assert_allclose(pin_places(turned, 1), [turned.map.to_map(at) for at in (FIRST, SECOND)], atol=1e-12)


def test_second_pin_at_a_place_and_pin_off_the_patch_are_rejected(pinned):
    with pytest.raises(MapError, match="pin is already"):
        add_pin(pinned, FIRST)
    for at in (replace(FIRST, face=-1), replace(FIRST, face=10_000), replace(FIRST, weights=(1.0, 1.0, -1.0))):
        with pytest.raises(MapError, match="not on the patch"):
            add_pin(pinned, at)
    with pytest.raises(MapError, match="unknown patch"):
        add_pin(pinned, replace(FIRST, patch=7))


def test_nudged_pin_reaches_its_target_and_others_do_not_move(pinned):
    goal = pin_places(pinned, 1)[0] + [0.004, -0.003]
    new = apply_result(pinned, reflatten(nudge_pins(pinned, {1: [0]}, (0.004, -0.003))))
    size = np.ptp(pinned.map.boxes[1], axis=0).max()
    np.testing.assert_allclose(new.map.to_map(FIRST), goal, atol=2e-3 * size)
    np.testing.assert_allclose(new.map.to_map(SECOND), pinned.map.to_map(SECOND), atol=2e-3 * size)
    np.testing.assert_allclose(pin_places(new, 1), [goal, pin_places(pinned, 1)[1]], atol=1e-12)
    _valid(new)


def test_drag_shows_no_flip_and_settles_at_the_release_point(pinned):
    gripped = begin_pin_drag(pinned, 1)
    start = pin_places(pinned, 1)
    for k in range(1, 13):
        goal = start[0] + np.array([0.001, 0.0005]) * k
        gripped.move(0, chart_place(pinned, 1, goal))
        gripped.frame()
        shown = with_dragged_patch(pinned, 1, gripped)
        assert not flipped(shown.charts[1].plane, shown.charts[1].faces).any()
        np.testing.assert_allclose(pin_places(shown, 1), [goal, start[1]], atol=1e-12)
        np.testing.assert_allclose(shown.charts[1].plane.min(axis=0), 0, atol=1e-12)
    exact = apply_result(shown, reflatten(finish_pin_drag(shown, 1)))
    size = np.ptp(pinned.map.boxes[1], axis=0).max()
    np.testing.assert_allclose(exact.map.uv[1].mean(axis=0), shown.map.uv[1].mean(axis=0), atol=0.01 * size)
    np.testing.assert_allclose(exact.map.to_map(FIRST), goal, atol=2e-3 * size)
    _valid(exact)


def test_map_without_pins_is_the_map_of_its_method(document, pinned):
    moved = apply_result(pinned, reflatten(nudge_pins(pinned, {1: [0]}, (0.005, 0.0))))
    one = apply_result(moved, reflatten(remove_pins(moved, 1, [0])))
    assert [pin.at for pin in one.patches[1].pins] == [SECOND]
    none = apply_result(one, reflatten(remove_pins(one, 1, [0])))
    np.testing.assert_array_equal(none.charts[1].plane, document.charts[1].plane)


def test_unknown_pins_and_invalid_places_are_rejected(pinned):
    for act in (lambda k: nudge_pins(pinned, {1: [k]}, (0.0, 0.0)), lambda k: remove_pins(pinned, 1, [k])):
        for number in (-1, 2):
            with pytest.raises(MapError, match="unknown pin"):
                act(number)
    with pytest.raises(MapError, match="target is not finite"):
        nudge_pins(pinned, {1: [0]}, (np.nan, 0.0))
    assert remove_pins(pinned, 1, []).jobs == ()


def test_pins_of_several_patches_are_nudged_or_removed_in_one_step(pinned):
    both = add_pin(pinned, SurfacePoint(2, 5, (0.2, 0.3, 0.5)))
    asked = nudge_pins(both, {1: [1], 2: [0]}, (0.002, -0.001))
    assert [job.number for job in asked.jobs] == [1, 2]
    new = apply_result(both, reflatten(asked))
    np.testing.assert_allclose(pin_places(new, 1) - pin_places(both, 1), [[0, 0], [0.002, -0.001]], atol=1e-12)
    np.testing.assert_allclose(pin_places(new, 2) - pin_places(both, 2), [[0.002, -0.001]], atol=1e-12)
    _valid(new)
    bare = apply_result(new, reflatten(unpin(new, {1: [0, 1], 2: [0]})))
    assert [len(patch.pins) for patch in bare.patches] == [0, 0, 0]
    with pytest.raises(MapError, match="unknown pin"):
        nudge_pins(both, {1: [2]}, (0.0, 0.0))
    with pytest.raises(MapError, match="target is not finite"):
        nudge_pins(both, {1: [0]}, (np.inf, 0.0))
    with pytest.raises(MapError, match="unknown pin"):
        unpin(both, {1: [0], 2: [1]})
