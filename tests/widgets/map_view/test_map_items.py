"""What the items of the map draw with."""

from __future__ import annotations

import numpy as np

from widgets.map_view.map_items import LineBuffer


def test_lines_filled_again_are_those_of_the_newest_segments():
    buffer, random = LineBuffer(), np.random.default_rng(0)
    for count in (3, 50, 0, 7):
        segments = random.normal(size=(count, 2, 2))
        lines = buffer.fill(segments)
        found = [[[line.x1(), line.y1()], [line.x2(), line.y2()]] for line in lines]
        assert np.array_equal(np.reshape(found, (-1, 2, 2)), segments)
