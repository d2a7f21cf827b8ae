"""Point: everything on the nearest taxel."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind
from tactile_maps.tactile.mechanics.loads import Box, Load, Sphere, sphere_load
from tactile_maps.tactile.mechanics.receptive_field import quadrature_points
from tactile_maps.tactile.models.half_space import HalfSpaceModel
from tactile_maps.tactile.models.point import PointModel
from tactile_maps.tactile.models.punch import PunchModel
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tests.support.touch import arm, bar_skin

SKIN = bar_skin()
UP = np.array([0.0, 0.0, 1.0])
FELT = PointModel(SKIN)


def press(point, force=5.0, *, normal=UP, link="bar"):
    return sphere_load(link, np.asarray(point, dtype=float), normal, force, 0.008)


@pytest.mark.long
def test_taxel_of_the_nearest_facing_point_reads_the_whole_force():
    skin = arm().skin
    points = quadrature_points(skin)
    felt = PointModel(skin)
    covered = np.array([patch.link for patch in skin.patches])[skin.patch_of[points.taxel]]
    for number in range(0, len(points.areas), 97):
        normal = points.normals[number]
        load = press(points.positions[number] + 1e-3 * normal, normal=normal, link=covered[number])
        candidates = np.flatnonzero((covered == load.link) & (points.normals @ normal > 0.2))
        away = np.linalg.norm(points.positions[candidates] - load.point, axis=1)
        taxel = points.taxel[candidates[away.argmin()]]
        pressures = felt.pressures([load])
        assert pressures[taxel] == pytest.approx(5.0 / skin.areas[taxel], rel=1e-12)
        assert np.count_nonzero(pressures) == 1
        assert felt.notes == ()


def test_edge_carries_load_and_load_off_the_skin_is_noted():
    edge = FELT.pressures([press((0.005, 0, 0.02), normal=np.array([-1.0, 0, 0]))])
    assert edge @ SKIN.areas == pytest.approx(5.0, rel=1e-12)
    assert not FELT.pressures([press((-0.2, 0, 0.02))]).any()
    assert FELT.notes == (ContactNote(ContactNoteKind.OUTSIDE_SKIN, ("bar",)),)


@pytest.mark.parametrize("normal", [UP, np.array([-1.0, 0.0, 0.0])], ids=["facing", "edge"])
@pytest.mark.parametrize("shape", [Sphere(0.02), Box((0.03, 0.03, 0.01))], ids=["ball", "box"])
def test_all_models_agree_on_which_bodies_touch_the_skin(shape, normal):
    """The border of the skin is at x = 0.01 m; the body is moved beyond it, up to 60 mm."""
    models = (FELT, WaterFillModel(SKIN), PunchModel(SKIN), HalfSpaceModel(SKIN))
    felt = set()
    for x in np.linspace(0.02, -0.05, 15):
        place = np.array([x, 0.0, 0.02])
        high = shape.radius if isinstance(shape, Sphere) else shape.half[2]
        load = Load("bar", place, normal, 5.0, shape, Pose(np.eye(3), place + np.array([0.0, 0.0, high - 1e-4])), "it")
        totals = [model.pressures([load]) @ SKIN.areas for model in models]
        kinds = [{note.kind for note in model.notes} - {ContactNoteKind.MOMENT_IGNORED} for model in models]
        assert totals == pytest.approx(np.full(4, totals[0]), rel=1e-9)
        assert all(kind == kinds[0] for kind in kinds)
        assert (totals[0] == 0) == (kinds[0] == {ContactNoteKind.OUTSIDE_SKIN})
        felt.add(bool(totals[0]))
    assert felt == {True, False}
