"""Readings are shown on a scene's robot, or on a skin that no robot carries."""

from __future__ import annotations

import numpy as np

from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import MapDocument
from tactile_maps.live.prepare import MEASURED_TICK, as_measured, prepare_measured
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.scene.scene_file import scene_for_taxels
from tactile_maps.skin.model.skin_file import save_skin
from tests.support.touch import bar_map, bar_skin, prepared_bar


def test_given_map_keeps_its_own_surface(tmp_path):
    path = tmp_path / "bar.npz"
    drawn = move(MapDocument.of(bar_map()), [0], (0.2, 0.1)).map
    save_map(drawn, path)
    prepared = prepare_measured(scene_for_taxels(str(path)))
    assert [link.name for link in prepared.robot.links] == [patch.link for patch in bar_skin().patches]
    assert np.array_equal(prepared.map.taxel_points, drawn.taxel_points)
    assert prepared.robot.joints == ()
    assert prepared.scene.tick == MEASURED_TICK
    assert MeasuredSession(prepared).frame.posture.shape == (0,)


def test_skin_without_a_map_gets_one(tmp_path):
    save_skin(bar_skin(), tmp_path / "bar.npz")
    assert len(prepare_measured(scene_for_taxels(str(tmp_path / "bar.npz"))).map.taxel_points) == 60


def test_scene_is_prepared_for_measured_readings():
    prepared = as_measured(prepared_bar())
    assert prepared.scene.tick == MEASURED_TICK
    assert prepared.objects == ()
