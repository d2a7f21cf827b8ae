"""The characteristic shape of points, and a learned map made a tactile map with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.detection import ContactDetector
from tactile_maps.core.errors import MapError
from tactile_maps.flattening.bijectivity import crossings, flipped
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.maps.formats.map_file import map_from_bytes, map_to_bytes
from tactile_maps.maps.learned.as_tactile_map import characteristic_shape, learned_tactile_map, longest_side
from tactile_maps.maps.learned.learned_map import LearnedMap
from tactile_maps.maps.learned.methods import LEARNING_METHODS
from tactile_maps.maps.model.interpolation import LONGEST_SIDE
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.tactile.babbling import BabbleSpec, babble
from tactile_maps.tactile.mechanics.loads import sphere_load
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tests.support.surfaces import frustum, sheet, skin_of


def _lattice(keep):
    i, j = np.meshgrid(np.arange(16), np.arange(12), indexing="ij")
    points = np.stack([i + 0.5 * (j % 2), np.sqrt(0.75) * j], axis=-1).reshape(-1, 2)
    points += 0.02 * np.random.default_rng(11).normal(size=points.shape)
    return points[keep(*points.T)]


SHAPES = {
    "whole": lambda x, y: x > -9,
    "an L": lambda x, y: (x < 5) | (y < 4),
    "a U": lambda x, y: (x < 4) | (x > 11) | (y < 3),
    "with a hole": lambda x, y: (x - 8) ** 2 + (y - 5) ** 2 > 9,
    "two pieces": lambda x, y: (x < 5) | (x > 11),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_learned_map_is_one_disk_through_every_point(shape):
    points = _lattice(SHAPES[shape])
    faces = characteristic_shape(points).faces
    assert np.array_equal(np.unique(faces), np.arange(len(points)))
    assert Connectivity(faces).euler_characteristic == 1
    assert not len(Connectivity(faces).bow_tie_vertices)
    (loop,) = Connectivity(faces).boundary_loops
    assert not crossings(points[loop])
    assert not flipped(points, faces).any()


@pytest.mark.parametrize(
    ("shape", "bridged"), [("whole", 0), ("an L", 0), ("a U", 0), ("with a hole", 1), ("two pieces", 1)]
)
def test_gaps_open_to_the_outside_are_not_bridged(shape, bridged):
    points = _lattice(SHAPES[shape])
    shape = characteristic_shape(points)
    assert (shape.bridging > 0) == bridged
    sides = np.linalg.norm(points[shape.faces] - np.roll(points[shape.faces], 1, axis=1), axis=2)
    assert (sides.max(axis=1) > longest_side(points)).sum() == shape.bridging


def test_side_limit_is_a_multiple_of_the_spacing():
    assert longest_side(3 * np.stack([np.arange(5.0), np.zeros(5)], axis=1)) == pytest.approx(3 * LONGEST_SIDE)


@pytest.mark.parametrize("points", [np.eye(2), np.stack([np.arange(9.0), 2 * np.arange(9.0)], axis=1)])
def test_collinear_points_are_rejected(points):
    with pytest.raises(MapError):
        characteristic_shape(points)


def _by_hand(points, placed=None) -> LearnedMap:
    placed = np.ones(len(points), dtype=bool) if placed is None else placed
    return LearnedMap(points, placed, "by hand", 0.0, 0.0)


@pytest.fixture(scope="module")
def skin():
    return skin_of(sheet(30, 20), taxels=60)


@pytest.fixture(scope="module")
def perfect(skin):
    """Return the sheet's places turned, mirrored and scaled, which touch cannot distinguish."""
    places = skin.patches[0].taxels.positions[:, :2]
    turn = np.array([[np.cos(2), -np.sin(2)], [np.sin(2), np.cos(2)]])
    return _by_hand(7 * places @ turn * [-1, 1] + 3)


def _assert_valid(map_):
    """Disks without flips or crossings, every placed taxel where the learned map put it, and the way back the same."""
    for chart in map_.charts:
        assert not flipped(chart.plane, chart.faces).any()
    assert not crossings(*map_.outlines)
    for taxel in range(0, len(map_.skin), 5):
        at = map_.to_body(map_.taxel_points[taxel])
        assert map_.skin.position(at) == pytest.approx(map_.skin.position(map_.skin.taxel_point(taxel)), abs=1e-9)


def test_perfect_learned_map_reproduces_the_sheet(skin, perfect):
    map_ = learned_tactile_map(skin, perfect)
    _assert_valid(map_)
    assert map_.charts[0].findings == ()
    chart = map_.charts[0]
    surface = map_.skin.patches[0].surface
    sides = chart.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    flat = np.linalg.norm(chart.plane[sides[:, 0]] - chart.plane[sides[:, 1]], axis=1)
    assert flat == pytest.approx(np.linalg.norm(surface.vertices[sides[:, 0]] - surface.vertices[sides[:, 1]], axis=1))
    assert (surface.face_normals[:, 2] > 0.99).all(), "looks out as the taxels do"
    assert chart.plane.min(axis=0) == pytest.approx([0, 0])
    x, y = skin.patches[0].taxels.positions[:, :2].T
    assert np.corrcoef(map_.taxel_points[:, 1], x)[0, 1] > 0.999, "the body's long direction is up"
    assert np.corrcoef(map_.taxel_points[:, 0], -y)[0, 1] > 0.999, "and not mirrored"


def test_points_between_taxels_are_restored_in_a_round_trip(skin, perfect):
    map_ = learned_tactile_map(skin, perfect)
    generator = np.random.default_rng(14)
    inner = generator.uniform(map_.bounds[0], map_.bounds[1], size=(50, 2))
    found = [(point, map_.to_body(point)) for point in inner]
    inside = [(point, at) for point, at in found if at is not None]
    assert len(inside) > 30
    for point, at in inside:
        assert map_.to_map(at) == pytest.approx(point, abs=1e-12)
        assert map_.skin.position(at)[2] == pytest.approx(0, abs=1e-12)


def test_skin_of_the_learned_map_has_the_same_readings(skin, perfect):
    load = sphere_load("link 0", np.array([0.05, 0.03, 0.0]), np.array([0.0, 0, 1]), 5.0, 0.02)
    felt = WaterFillModel(learned_tactile_map(skin, perfect).skin).pressures([load])
    assert felt.max() > 0
    assert felt.tobytes() == WaterFillModel(skin).pressures([load]).tobytes()


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("method", LEARNING_METHODS)
@pytest.mark.parametrize("kind", ["unbiased", "biased"])
def test_image_and_contacts_work_on_every_learned_map(method, kind):
    skin = skin_of(sheet(20, 15), frustum(along=16, around=24), taxels=40)
    readings = babble(skin, BabbleSpec(kind, touches=400, noise=0.0))
    map_ = learned_tactile_map(skin, LEARNING_METHODS[method](readings))
    _assert_valid(map_)
    assert {chart.method for chart in map_.charts} == {method}
    image = TactileImage(map_, width=48)
    assert image.inside.mean() > 0.15
    touch = readings[3]
    assert touch.max() > 1000
    assert image.render(touch).max() == pytest.approx(1e-3 * touch.max(), rel=0.5)
    (region, *_) = ContactDetector(map_).read(touch)
    assert region.force > 0


def test_learned_map_can_be_saved(skin, perfect):
    map_ = learned_tactile_map(skin, perfect)
    again = map_from_bytes(map_to_bytes(map_))
    assert np.array_equal(again.taxel_points, map_.taxel_points)


def test_unplaced_taxel_is_at_the_closest_point_on_the_body(skin, perfect):
    placed = np.ones(60, dtype=bool)
    inner = np.linalg.norm(skin.patches[0].taxels.positions[:, :2] - [0.06, 0.04], axis=1)
    placed[inner.argmin()] = False
    map_ = learned_tactile_map(skin, replace(perfect, placed=placed))
    _assert_valid(map_)
    assert ("taxels-without-place", 1) in [(note.kind, note.count) for note in map_.charts[0].findings]
    whole = learned_tactile_map(skin, perfect)
    assert map_.taxel_points[inner.argmin()] == pytest.approx(whole.taxel_points[inner.argmin()], abs=2e-3)
    assert len(map_.charts[0].plane) == 59


def test_coincident_taxels_are_separated_and_reported(skin, perfect):
    points = perfect.points.copy()
    points[[4, 5, 6]] = points[3]
    map_ = learned_tactile_map(skin, _by_hand(points))
    _assert_valid(map_)
    assert ("taxels-on-one-place", 3) in [(note.kind, note.count) for note in map_.charts[0].findings]
    apart = np.linalg.norm(map_.taxel_points[3:7, None] - map_.taxel_points[None, 3:7], axis=-1)
    assert apart[np.triu_indices(4, 1)].min() > 0
    assert apart.max() < 1e-4


def test_triangles_between_links_are_omitted_and_reported():
    skin = skin_of(sheet(), sheet(), taxels=20)
    places = skin.patches[0].taxels.positions[:, :2]
    nearby = _by_hand(np.concatenate([places, places + [0.13, 0]]))
    map_ = learned_tactile_map(skin, nearby)
    _assert_valid(map_)
    (note,) = map_.charts[0].findings
    assert note.kind == "triangles-between-patches"
    assert [patch.link for patch in map_.skin.patches] == ["link 0", "link 1"]
    on_top = learned_tactile_map(skin, _by_hand(np.concatenate([places, places + 0.01])))
    _assert_valid(on_top)
    assert on_top.charts[0].findings[0].count > note.count


def test_invalid_learned_maps_are_rejected(skin, perfect):
    with pytest.raises(MapError, match="another skin"):
        learned_tactile_map(skin, _by_hand(perfect.points[1:]))
    with pytest.raises(MapError, match="fewer than three"):
        learned_tactile_map(skin, replace(perfect, placed=np.arange(60) < 2))
    with pytest.raises(MapError, match="one line"):
        learned_tactile_map(skin, _by_hand(np.outer(np.arange(60.0), [1, 2])))
