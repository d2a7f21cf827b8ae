"""The map's shapes: a patch's outline falls into skin border and seams, without loss and in long pieces."""

from __future__ import annotations

import numpy as np
import pytest

from widgets.map_view.map_shapes import MapShapes, split_loop

ANGLES = np.linspace(0, 2 * np.pi, 13)
LOOP = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
LOOP[-1] = LOOP[0]


def _length(lines):
    return sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines)


@pytest.mark.parametrize("shift", range(12))
def test_a_loop_falls_into_long_pieces(shift):
    marked = np.roll(np.array([True] * 3 + [False] * 4 + [True] * 2 + [False] * 3), shift)
    plain, seams = split_loop(LOOP, marked)
    assert sorted(len(line) for line in plain) == [4, 5]
    assert sorted(len(line) for line in seams) == [3, 4]
    edge = np.linalg.norm(LOOP[1] - LOOP[0])
    assert _length(plain) == pytest.approx(7 * edge)
    assert _length(seams) == pytest.approx(5 * edge)


def test_a_loop_of_one_kind_stays_whole():
    plain, seams = split_loop(LOOP, np.zeros(12, dtype=bool))
    assert (len(plain), seams) == (1, ())
    plain, seams = split_loop(LOOP, np.ones(12, dtype=bool))
    assert (plain, len(seams)) == ((), 1)


def test_shapes_of_a_real_map(prepared):
    shapes = MapShapes.of(prepared.map)
    assert [patch.name for patch in shapes.patches] == [patch.name for patch in prepared.skin.patches]
    assert shapes.taxels.shape == (len(prepared.skin), 2)
    assert shapes.pitch > 0
    for patch, seams in zip(shapes.patches, prepared.map.seams, strict=True):
        assert _length(patch.border) + _length(patch.seam) == pytest.approx(_length([patch.outline]))
        cut = np.asarray(seams).reshape(-1, 2, 2)
        assert _length(patch.seam) == pytest.approx(shapes.frame.scale * _length(cut), rel=1e-6)
