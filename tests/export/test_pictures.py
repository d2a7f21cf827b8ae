"""A picture has the map's outlines, a colour bar and the contacts, in even numbers of pixels."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.export.pictures import FilmFrame
from tactile_maps.maps.pressure_colours import COLOURS

pytestmark = pytest.mark.long


def test_image_size_is_even_and_colour_bar_runs_from_dark_to_pale(player, frames):
    canvas = FilmFrame(player.prepared.map, 10.0)
    width, height = canvas.size
    picture = canvas.picture(frames[0])
    assert picture.shape == (height, width, 3)
    assert width % 2 == height % 2 == 0
    bar = picture[:, width - 96 + 5]
    inside = np.flatnonzero((bar == COLOURS[255]).all(axis=1))
    assert inside.size
    assert (bar[inside[-1] :] == COLOURS[0]).all(axis=1).any()


def test_contact_is_marked_at_its_position(player, frames):
    canvas = FilmFrame(player.prepared.map, 50.0)
    frame = next(frame for frame in frames if frame.regions)
    blue = (canvas.picture(frame) == (31, 119, 180)).all(axis=2)
    assert blue.any()
    assert not (canvas.picture(frames[0]) == (31, 119, 180)).all(axis=2).any()
