"""Plots in millimetres and kPa."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from tactile_maps.contacts.pipeline import read_contacts
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import MapError
from tactile_maps.plot import draw_contacts, draw_forces, draw_map
from tactile_maps.session.session import Session
from tactile_maps.tactile.press import press_skin
from tests.support.touch import prepared_bar

BAR = prepared_bar()
PRESSURES = press_skin(BAR.skin, BAR.skin.taxel_point(30), force=3.0)


def axes():
    return Figure().subplots()


def test_bare_map_shows_every_patch_and_taxel():
    ax = draw_map(BAR.map, ax=axes())
    assert {text.get_text() for text in ax.texts} == {patch.name for patch in BAR.skin.patches}
    points = np.concatenate([line.get_xydata() for line in ax.lines])
    for taxel in 1e3 * BAR.map.taxel_points:
        assert np.isclose(points, taxel).all(axis=1).any()
    assert not ax.images


def test_pressures_are_shown_at_the_taxels_in_kilopascals():
    ax = draw_map(BAR.map, PRESSURES, ax=axes(), width=256)
    (image,) = ax.images
    assert image.norm.vmax == pytest.approx(1e-3 * PRESSURES.max())
    left, right, bottom, top = image.get_extent()
    values = np.ma.filled(image.get_array(), 0.0)
    row, column = np.unravel_index(values.argmax(), values.shape)
    x = left + (column + 0.5) * (right - left) / values.shape[1]
    y = top - (row + 0.5) * (top - bottom) / values.shape[0]
    strongest = 1e3 * BAR.map.taxel_points[PRESSURES.argmax()]
    assert np.hypot(*(np.array([x, y]) - strongest)) < 4 * (right - left) / values.shape[1] + 0.5
    assert draw_map(BAR.map, PRESSURES, full_scale=50.0, ax=axes()).images[0].norm.vmax == 50.0


def test_contact_is_marked_at_its_centre_with_its_force():
    contacts = read_contacts(BAR.map, PRESSURES)
    ax = draw_contacts(contacts, ax=axes())
    assert [text.get_text() for text in ax.texts] == ["3.00 N"]
    np.testing.assert_allclose(ax.lines[-1].get_xydata(), [1e3 * contacts[0].map_point])


def test_forces_are_drawn_contact_by_contact():
    session = Session(BAR, scripted=False, settings=ControlSettings(controller="hold_force"))
    frames = []
    session.press(BAR.skin.taxel_point(30), force=1.0)
    with session.watched(frames.append):
        session.run_for(0.3)
    (line,) = draw_forces(frames, ax=axes()).lines
    touched = [frame for frame in frames if frame.regions]
    np.testing.assert_allclose(line.get_xdata(), [frame.time for frame in touched])
    np.testing.assert_allclose(line.get_ydata(), [frame.regions[0].force for frame in touched])


def test_pressures_of_another_skin_are_rejected():
    with pytest.raises(MapError, match="pressures do not fit this skin"):
        draw_map(BAR.map, np.zeros(3), ax=axes())
