"""Marks of dead, stuck and blind taxels on the body: at their taxels, in every pose, and gone with the faults."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_widgets.common.colours import LIGHT
from tactile_widgets.overlays.taxel_faults import NO_FAULTS, TaxelFaults
from tactile_widgets.views.robot.actors.camera import look_from


@pytest.fixture
def faults(prepared):
    """A dead taxel whose neighbours are stuck: it is blind."""
    skin = prepared.skin
    pairs = skin.neighbours
    kinds = np.zeros(len(skin), np.int8)
    kinds[np.unique(pairs[(pairs == 40).any(axis=1)])] = 2
    kinds[40] = 1
    return TaxelFaults(kinds).with_areas(skin, estimated=True)


def picture(scene):
    scene.plotter.render()
    return scene.plotter.screenshot(return_img=True).astype(int)


def look_at(scene, prepared, taxel):
    point, normal = scene.point(prepared.skin.taxel_point(taxel))
    view = scene.viewpoint
    scene.look(look_from(replace(view, eye=view.eye + point - view.focus, focus=point), normal))


def marked_taxels(scene, prepared):
    """The taxels nearest to the corners of all marks."""
    found = set()
    for number, mark in enumerate(scene._fault_marks._marks):
        mesh, actor = mark._mesh, mark.actor
        if actor.visibility:
            taxels = prepared.skin.patches[number].taxels
            places = np.asarray(mesh.points).reshape(-1, 6, 3).mean(axis=1)  # the middles of lines
            away = np.linalg.norm(places[:, None] - taxels.positions, axis=2)
            found |= set((away.argmin(axis=1) + prepared.skin.first[number]).tolist())
    return found


def test_broken_taxels_are_marked_at_their_locations(scene, prepared, faults):
    look_at(scene, prepared, 40)
    before = picture(scene)
    scene.set_faults(replace(faults, blind=()))
    assert marked_taxels(scene, prepared) == set(np.flatnonzero(faults.broken).tolist())
    crossed = picture(scene)
    assert (crossed != before).any()
    scene.set_faults(faults)
    assert len(faults.blind) > 0
    assert (crossed != picture(scene)).any(), "a missing taxel looks different from an estimated one"
    scene.set_faults(NO_FAULTS)
    assert marked_taxels(scene, prepared) == set()
    np.testing.assert_array_equal(picture(scene), before)


def test_marks_follow_their_link_and_are_hidden_off_the_body(scene, prepared, faults):
    scene.set_faults(faults)
    patch = int(prepared.skin.patch_of[40])
    actor = scene._fault_marks._marks[patch].actor
    pose = scene.poses[prepared.robot.link_index[prepared.skin.patches[patch].link]]
    np.testing.assert_allclose(np.asarray(actor.user_matrix), pose)
    scene.morph(0.5)
    assert marked_taxels(scene, prepared) == set()
    scene.morph(0.0)
    assert 40 in marked_taxels(scene, prepared)
    scene.set_theme(LIGHT)
    assert 40 in marked_taxels(scene, prepared)


def test_faults_of_another_skin_are_not_marked(scene, prepared):
    scene.set_faults(TaxelFaults(np.ones(len(prepared.skin) + 1, np.int8)))
    assert marked_taxels(scene, prepared) == set()
