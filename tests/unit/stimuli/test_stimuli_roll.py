"""A rolling fingertip: its contact moves as far over the skin as over itself."""

from __future__ import annotations

import numpy as np
import pytest

from app.skin.skin import Patch, Skin
from app.stimuli.place import Ground
from app.stimuli.roll import Roll
from tests.touch import arm, bar_skin


def test_on_a_plane_the_contact_sways_by_radius_times_angle():
    roll = Roll(at=(0.2, 0.0, 0.02), radius=0.01, angle=90.0, rolls=3, seconds=2.0, hold=0.5)
    (track,) = roll.tracks(Ground(bar_skin()))
    assert track.times[-1] == pytest.approx(0.5 + 3 * 2.0)
    times = np.linspace(0.5, 6.5, 601)
    away = np.array([track.at(time)[1] for time in times]) - [0.2, 0.0, 0.02]
    wanted = 0.01 * np.pi / 2 * np.sin(2 * np.pi * (times - 0.5) / 2.0)
    assert np.abs(away[:, 0] - wanted).max() < 0.01 * 0.005, "along the bar's long axis, as a sine"
    assert np.abs(away[:, 1:]).max() < 5e-5
    assert np.array_equal(track.at(0.4)[1], track.points[0]), "pressed in before it rolls"


def test_the_heading_turns_it_about_the_normal():
    (track,) = Roll(at=(0.2, 0.0, 0.02), heading=90.0, rolls=1).tracks(Ground(bar_skin()))
    away = track.points - [0.2, 0.0, 0.02]
    assert np.ptp(away[:, 1]) > 0.01
    assert np.abs(away[:, 0]).max() < 5e-5
    assert away[len(away) // 4, 1] > 0.005, "first to the left of the long axis, seen from outside"


def test_on_a_curved_link_it_keeps_to_the_skin():
    ground = Ground(arm().skin)
    (track,) = Roll(patch="forearm", heading=60.0).tracks(ground)
    assert np.abs(ground.lay(1, track.points) - track.points).max() < 1e-4
    assert np.linalg.norm(np.ptp(track.points, axis=0)) == pytest.approx(2 * 0.008 * np.pi / 3, rel=0.1)


def test_on_a_cap_the_next_axis_gives_the_heading():
    """A skin whose long axis stands on the touched place."""
    upright = bar_skin().patches[0]
    turn = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])
    surface = type(upright.surface)(upright.surface.vertices @ turn.T, upright.surface.faces)
    skin = Skin((Patch("wall", "bar", surface, upright.taxels),))
    (track,) = Roll(at=(0.02, 0.0, -0.2)).tracks(Ground(skin))
    assert np.isfinite(track.points).all()
    assert np.ptp(track.points, axis=0).max() > 0.01
