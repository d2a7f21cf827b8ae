"""Each kind of stimulus: the tracks of its fingers."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tactile_maps.core.errors import SceneError
from tactile_maps.geometry.surface.points import cumulative_lengths
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.stimuli.skin_locations import SkinLocator, principal_axes
from tactile_maps.stimuli.stimulus_kinds import Babble, FingerPath, Grasp, Roll, Stroke, Tap
from tactile_maps.tactile.babbling import BabbleSpec, touched_places
from tests.support.touch import arm, bar_skin


def test_taps_are_short_pokes_of_one_finger():
    tracks = Tap(at=(0.1, 0.0, 0.02), taps=3, down=0.1, up=0.2).tracks(SkinLocator(bar_skin()))
    assert [track.finger for track in tracks] == [0, 0, 0]
    assert np.allclose([track.times for track in tracks], [[0.0, 0.1], [0.3, 0.4], [0.6, 0.7]])
    assert len({track.points.tobytes() for track in tracks}) == 1
    assert tracks[0].tip.speed > 0.05, "quick enough to be felt in so short a time"


def test_stroke_holds_then_moves_then_stays_at_its_end():
    stroke = Stroke(patch="forearm", start=(0.1, 0.2), end=(0.9, 0.4), hold=0.5, speed=0.05, stay=0.3)
    (track,) = stroke.tracks(SkinLocator(arm().skin))
    length = cumulative_lengths(track.points)[-1]
    assert length > 0.1
    assert track.times[-1] == pytest.approx(0.5 + length / 0.05 + 0.3)
    assert np.array_equal(track.at(0.49)[1], track.points[0])
    assert np.array_equal(track.at(track.times[-1] - 0.29)[1], track.points[-1])
    for start, end in ((0.5, 1.5), (1.0, 2.0)):
        way = np.array([track.at(time)[1] for time in np.linspace(start, end, 401)])
        assert cumulative_lengths(way)[-1] == pytest.approx(0.05, rel=0.01)


def test_contact_on_a_plane_sways_by_radius_times_angle():
    roll = Roll(at=(0.2, 0.0, 0.02), radius=0.01, angle=90.0, rolls=3, seconds=2.0, hold=0.5)
    (track,) = roll.tracks(SkinLocator(bar_skin()))
    assert track.times[-1] == pytest.approx(0.5 + 3 * 2.0)
    times = np.linspace(0.5, 6.5, 601)
    away = np.array([track.at(time)[1] for time in times]) - [0.2, 0.0, 0.02]
    expected = 0.01 * np.pi / 2 * np.sin(2 * np.pi * (times - 0.5) / 2.0)
    assert np.abs(away[:, 0] - expected).max() < 0.01 * 0.005, "along the bar's long axis, as a sine"
    assert np.abs(away[:, 1:]).max() < 5e-5
    assert np.array_equal(track.at(0.4)[1], track.points[0]), "pressed in before it rolls"


def test_heading_rotates_the_motion_about_the_normal():
    (track,) = Roll(at=(0.2, 0.0, 0.02), heading=90.0, rolls=1).tracks(SkinLocator(bar_skin()))
    away = track.points - [0.2, 0.0, 0.02]
    assert np.ptp(away[:, 1]) > 0.01
    assert np.abs(away[:, 0]).max() < 5e-5
    assert away[len(away) // 4, 1] > 0.005, "first to the left of the long axis, seen from outside"


def test_heading_on_a_cap_follows_the_next_axis():
    """The long axis of the skin is normal to the surface at the touched point."""
    upright = bar_skin().patches[0]
    turn = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])
    surface = type(upright.surface)(upright.surface.vertices @ turn.T, upright.surface.faces)
    skin = Skin((Patch("wall", "bar", surface, upright.taxels),))
    (track,) = Roll(at=(0.02, 0.0, -0.2)).tracks(SkinLocator(skin))
    assert np.isfinite(track.points).all()
    assert np.ptp(track.points, axis=0).max() > 0.01


def test_path_reaches_its_places_at_its_times():
    points = ((0.0, 0.1, 0.0, 0.02), (0.5, 0.2, 0.0, 0.02), (2.0, 0.2, 0.04, 0.02))
    (track,) = FingerPath(points=points).tracks(SkinLocator(bar_skin()))
    for time, *place in points:
        assert np.allclose(track.at(time)[1], place, atol=1e-9)
    assert np.allclose(track.at(0.25)[1], [0.15, 0, 0.02], atol=1e-9)


@pytest.mark.parametrize("fingers", [2, 3, 5])
def test_fingers_of_a_grasp_surround_the_link_and_forces_cancel(fingers):
    skin = arm().skin
    locator = SkinLocator(skin)
    axis = principal_axes(skin.patches[1])[0]
    tracks = Grasp(patch="forearm", at=(0.5, 0.1), fingers=fingers, hold=2.0).tracks(locator)
    assert [track.finger for track in tracks] == list(range(fingers))
    points = np.array([track.points[0] for track in tracks])
    assert np.ptp(points @ axis) < 1e-5, "all in one section"
    normals = np.array([skin.normal(locator.surface_point(int(t.patches[0]), t.points[0])) for t in tracks])
    assert np.linalg.norm(normals.sum(axis=0)) < 0.1 * fingers
    assert all(np.array_equal(track.times, [0.0, 2.0]) for track in tracks)
    assert {skin.patches[int(t.patches[0])].link for t in tracks} == {"forearm"}


def test_grasp_of_a_link_with_skin_on_one_side_is_rejected():
    with pytest.raises(SceneError, match=r"grasp\.fingers.*no skin.*bar"):
        Grasp(at=(0.2, 0.0, 0.02)).tracks(SkinLocator(bar_skin()))


def tracks(**values):
    return Babble(**values).tracks(SkinLocator(arm().skin))


def test_babbled_touches_follow_each_other_at_the_places_of_babbling():
    found = tracks(touches=30, seed=5)
    places = touched_places(arm().skin, BabbleSpec(touches=30, samples=5, seed=5))
    assert np.allclose([track.points[0] for track in found], places.positions[:, 0, 0], atol=0.002)
    assert [int(track.patches[0]) for track in found] == places.patches[:, 0, 0].tolist()
    assert all(one.times[-1] + 0.19 < other.times[0] for one, other in pairwise(found))


def test_forces_and_shares_follow_the_stimulus():
    found = tracks(touches=200, strokes=0.3, length=0.03, force=2.0)
    forces = np.array([track.tip.max_force for track in found])
    assert 1.0 <= forces.min() < 1.2
    assert 2.8 < forces.max() <= 3.0
    moving = [track for track in found if len(track.times) > 2]
    assert len(moving) / 200 == pytest.approx(0.3, abs=0.1)
    assert np.median([cumulative_lengths(track.points)[-1] for track in moving]) >= 0.028


def test_touches_depend_on_the_seed_and_not_on_the_strokes():
    one = tracks(seed=1)[0]
    other = tracks(seed=2)[0]
    assert not np.array_equal(one.points[0], other.points[0])
    assert one.tip != other.tip
    still = tracks(strokes=0.0)
    moving = tracks(strokes=1.0)
    assert all(np.array_equal(a.points[0], b.points[0]) for a, b in zip(still, moving, strict=True))
    assert all(a.tip == b.tip for a, b in zip(still, moving, strict=True))


def test_babbling_modes_with_several_places_use_several_fingers():
    pairs = tracks(way="self-touch", touches=10, strokes=0.0)
    assert [track.finger for track in pairs] == [0, 1] * 10
    assert all(a.patches[0] != b.patches[0] for a, b in zip(pairs[::2], pairs[1::2], strict=True))
    assert all(a.tip == b.tip for a, b in zip(pairs[::2], pairs[1::2], strict=True))
    assert len(tracks(way="multi-touch", touches=4)) == 12
    assert 10 <= len(tracks(way="biased", touches=10)) <= 20


def test_babbling_on_one_patch_touches_only_this_patch():
    assert {int(track.patches[0]) for track in tracks(patch="hand", touches=40)} == {2}
    with pytest.raises(SceneError, match="no taxels"):
        Babble().tracks(SkinLocator(Skin(())))
