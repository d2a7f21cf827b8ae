"""A map is built in one call, with progress and cancellation."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.flattening.cut import SeamPlan, shortest_edge_path
from tactile_maps.maps.build import build_map, flatten_patch, with_chart
from tactile_maps.robots.load import robot_of_mesh
from tactile_maps.skin.model.skin import Patch, Skin
from tests.support.surfaces import frustum, sheet, skin_of, taxels_on


def test_every_patch_gets_a_chart_in_order(three_patches):
    assert [len(chart.faces) for chart in three_patches.charts] == [
        len(patch.surface.faces) for patch in three_patches.skin.patches
    ]


def test_progress_names_the_patch_and_never_decreases():
    heard = []
    build_map(skin_of(sheet(), frustum()), progress=lambda text, fraction: heard.append((text, fraction)))
    fractions = [fraction for _, fraction in heard]
    assert fractions == sorted(fractions)
    assert (fractions[0], fractions[-1]) == (0.0, 1.0)
    second = {fraction for text, fraction in heard if text == "Flattening patch 1"}
    assert second == {192 / (192 + 1440)}
    assert {text for text, _ in heard} == {"Flattening patch 0", "Flattening patch 1", "Arranging the map"}
    assert len(heard) > 10, "every iteration is reported, so that the work can be stopped soon"


def test_exception_in_progress_cancels_the_build():
    class StopError(Exception):
        pass

    def stop(_text, fraction):
        if fraction > 0:
            raise StopError

    with pytest.raises(StopError):
        build_map(skin_of(sheet(), frustum()), progress=stop)


def test_method_reaches_every_chart():
    assert {chart.method for chart in build_map(skin_of(sheet(), sheet()), method="tutte").charts} == {"tutte"}


def test_skin_without_patches_raises_a_clear_error():
    with pytest.raises(MapError, match="no patches"):
        build_map(Skin(()))


def test_error_names_the_patch_that_cannot_be_flattened():
    whole = sheet()
    broken = type(whole)(whole.vertices, [*whole.faces.tolist(), [0, 10, 60]])
    skin = Skin((Patch("shin", "leg", broken, taxels_on(whole, 10)),))
    with pytest.raises(MapError, match="shin"):
        build_map(skin)


def test_flattening_one_patch_again_keeps_the_others(three_patches):
    patch = three_patches.skin.patches[1]
    chart = flatten_patch(patch, seams=SeamPlan(extra=1))
    edited = with_chart(three_patches, 1, chart)
    assert edited.charts[0] is three_patches.charts[0]
    assert edited.charts[2] is three_patches.charts[2]
    assert edited.layout.placements[::2] == three_patches.layout.placements[::2]
    before, after = (m.uv[1].min(axis=0) + m.uv[1].max(axis=0) for m in (three_patches, edited))
    np.testing.assert_allclose(after, before, atol=1e-12)


def test_map_of_a_robot_is_rejected_with_a_remedy():
    with pytest.raises(TypeError, match=r"needs a Skin \(found: Robot\). Cover the robot first"):
        build_map(robot_of_mesh(frustum(), name="cone", source="cone.stl", link="cone"))


def test_seam_plan_for_unknown_patch_is_rejected():
    with pytest.raises(MapError, match=r"unknown patch.*elbow"):
        build_map(skin_of(sheet()), seams={"elbow": SeamPlan()})


def test_requested_seams_are_cut():
    skin = skin_of(sheet(), frustum())
    surface = skin.patches[1].surface
    up = np.lexsort((surface.vertices[:, 2], np.round(np.arctan2(*surface.vertices[:, :2].T), 6)))
    drawn = shortest_edge_path(surface, [int(up[0]), int(up[20])])
    map_ = build_map(skin, seams={"patch 1": SeamPlan(drawn=drawn)})
    cut = {tuple(seam) for seam in map_.charts[1].seams.tolist()}
    assert cut == {tuple(edge) for edge in drawn.tolist()}
