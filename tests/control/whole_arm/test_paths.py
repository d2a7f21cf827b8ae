"""Paths drawn on the map, on the whole arm: over seams, from patch to patch, from link to link, and where it cannot."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.command import RegraspState as State
from tactile_maps.control.motion.joint_impedance import MAX_JOINT_SPEED
from tactile_maps.control.motion.limits import LimitKind, RegraspFailure
from tactile_maps.editing.arrange import move, rotate
from tactile_maps.editing.document import MapDocument
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.layout import MapLayout
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.inputs import ControlChanged, MapEdited
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tests.support.pressed_arm import Course, forearm, pressed_by_ball

pytestmark = pytest.mark.long

LINE = ControlSettings(controller="hybrid", task="follow_path", path_kind="polyline", path_speed=0.03, force_gain=0.015)


class Trip(Course):
    """A course with the progress along the path at each tick.

    Attributes:
        piece: (k,) piece of the path.
        regrasp: (k,) state of the regrasp.
        link: (k,) touched link; empty without contact.
    """

    def __init__(self, session: Session, seconds: float, **more) -> None:
        self.piece: list[int] = []
        self.regrasp: list[State | None] = []
        self.link: list[str] = []
        super().__init__(session, seconds, **more)

    def _see(self, k: int, session: Session) -> None:
        super()._see(k, session)
        frame = session.frame
        self.piece.append(frame.task.piece)
        self.regrasp.append(frame.task.regrasp)
        self.link.append(frame.regions[0].link if frame.regions else "")

    @property
    def states(self) -> list[State]:
        """Return the sequence of states of the regrasps."""
        return [now for before, now in zip([None, *self.regrasp], self.regrasp, strict=False) if now and now != before]


@cache
def two_links() -> PreparedScene:
    """Our arm with 500 taxels on forearm and hand, and the scene that ships with a path over both."""
    return prepare_cached(load_scene("follow_path"))


@cache
def halves() -> PreparedScene:
    """The forearm's skin in two patches with a gap of some millimetres, next to each other on the map."""
    prepared = forearm()
    whole = prepared.skin.patches[0].surface
    middle = whole.vertices[whole.faces].mean(axis=1)[:, 2]
    cut = float(np.median(prepared.skin.patches[0].taxels.positions[:, 2]))
    patches = []
    for name, keep in (("near", middle < cut - 0.002), ("far", middle > cut + 0.002)):
        used, faces = np.unique(whole.faces[keep], return_inverse=True)
        surface = Mesh(whole.vertices[used], faces.reshape(-1, 3))
        patches.append(Patch(name, "forearm", surface, place_evenly(surface, 200, seed=0)))
    document = rotate(MapDocument.of(build_map(Skin(tuple(patches)))), [1], -np.pi / 2)
    (low, high), (left, _) = document.map.boxes
    document = move(document, [1], (high[0] + 0.005 - left[0], low[1] - left[1]))
    halved = replace(prepared, skin=document.map.skin, map=document.map)
    first, second = facing(halved)
    map_ = move(document, [1], (0.0, first[0][1] - second[0][1])).map
    return replace(halved, skin=map_.skin, map=map_)


def near(prepared: PreparedScene, patch: int, point) -> int:
    """The taxel of a patch nearest to a point of its link."""
    away = np.linalg.norm(prepared.skin.patches[patch].taxels.positions - np.asarray(point), axis=1)
    return int(prepared.skin.first[patch] + away.argmin())


def on_map(prepared: PreparedScene, *places) -> tuple[tuple[float, float], ...]:
    """Return points of the map, given as taxels or as points."""
    points = [prepared.map.taxel_points[place] if isinstance(place, int | np.integer) else place for place in places]
    return tuple((float(x), float(y)) for x, y in points)


def bounded(trip: Trip, *, force=20.0) -> None:
    assert np.isfinite(trip.force).all()
    assert trip.pressed.max() < force
    assert trip.speed.max() < MAX_JOINT_SPEED


def over_a_seam(prepared: PreparedScene) -> tuple[int, tuple[tuple[float, float], ...]]:
    """Return a taxel near the seam of the forearm, and a line from it to 25 mm beyond the seam, outside the patch."""
    map_ = prepared.map
    seam = map_.seams[0]
    middles = seam.mean(axis=1)
    height = np.abs(middles[:, 1] - np.median(map_.taxel_points[:, 1])).argmin()
    middle = middles[height]
    along = seam[height][1] - seam[height][0]
    across = np.array([along[1], -along[0]]) / np.linalg.norm(along)
    across *= 1.0 if map_.to_body(middle + 1e-3 * across) is not None else -1.0
    taxel = int(np.linalg.norm(map_.taxel_points - (middle + 0.015 * across), axis=1).argmin())
    start = map_.taxel_points[taxel]
    return taxel, on_map(prepared, taxel, start - 0.04 * across)


def test_contact_continues_behind_a_seam():
    prepared = forearm()
    taxel, path = over_a_seam(prepared)
    assert prepared.map.to_body(np.array(path[1])) is None, "it is drawn off the patch"
    session = pressed_by_ball(replace(LINE, path=path, path_speed=0.01), taxel=taxel)
    trip = Trip(session, 4.5)
    bounded(trip)
    assert trip.states == []
    assert trip.way[-1] > 0.03
    jumped = np.linalg.norm(session.frame.regions[0].map_point - path[0])
    assert jumped > 0.1, "it is on the other side of the map"
    assert np.nanmedian(trip.body_error[200:]) < 0.005
    assert trip.force[200:] == pytest.approx(3.0, abs=0.8)
    assert trip.force[200:].mean() == pytest.approx(3.0, abs=0.1)


Border = tuple[np.ndarray, np.ndarray, np.ndarray]


def borders(prepared: PreparedScene, patch: int) -> list[Border]:
    """Middles of the sides of a patch's border, outward directions (2,) there [m], and the places on the body (3,)."""
    map_ = prepared.map
    outline = map_.outlines[patch]
    after = np.roll(map_.outlines[patch], -1, axis=0)
    found = []
    for middle, along in zip((outline + after) / 2, after - outline, strict=True):
        out = np.array([along[1], -along[0]]) / np.linalg.norm(along)
        for sign in (1, -1):
            inner = map_.to_body(middle - 1e-4 * sign * out)
            if inner is not None and map_.to_body(middle + 1e-3 * sign * out) is None:
                found.append((middle, sign * out, prepared.skin.position(inner)))
    return found


def facing(prepared: PreparedScene) -> tuple[Border, Border]:
    """Return two borders, one of each patch, that face each other on the body."""
    near_end = prepared.skin.patches[0].taxels.positions[:, 2].max()
    side = np.array([*forearm().skin.patches[0].taxels.positions[150, :2], near_end])
    first = min(borders(prepared, 0), key=lambda row: np.linalg.norm(row[2] - side))
    second = min(borders(prepared, 1), key=lambda row: np.linalg.norm(row[2] - first[2]))
    assert np.linalg.norm(second[2] - first[2]) < 0.01
    return first, second


def over_the_gap(prepared: PreparedScene) -> tuple[int, tuple[tuple[float, float], ...]]:
    """Return a taxel of the first half near the gap, and a path from it over the gap into the other half."""
    first, second = facing(prepared)
    path = [
        first[0] - 0.02 * first[1],
        first[0] + 1e-3 * first[1],
        second[0] + 1e-3 * second[1],
        second[0] - 0.03 * second[1],
    ]
    place = prepared.skin.position(prepared.map.to_body(path[0]))
    return near(prepared, 0, place), on_map(prepared, *path)


@pytest.mark.long
@pytest.mark.parametrize("controller", CONTROL_SCHEMES)
def test_contact_is_moved_straight_between_patches_of_one_link(controller):
    """The ball is felt by both patches at once, as two contacts: together they keep the force."""
    prepared = halves()
    taxel, path = over_the_gap(prepared)
    session = pressed_by_ball(
        replace(LINE, controller=controller, path=path, path_speed=0.01), prepared=prepared, taxel=taxel
    )
    trip = Trip(session, 5.0)
    bounded(trip)
    assert trip.states == []
    assert [trip.piece[k] for k in (0, -1)] == [0, 1]
    assert {region.at.patch for region in session.frame.regions} == {1}
    assert trip.pressed[200:] == pytest.approx(3.0, abs=1.0)
    assert trip.last(trip.pressed).mean() == pytest.approx(3.0, abs=0.1)
    assert trip.last(trip.body_error).max() < 0.008


@pytest.mark.long
@pytest.mark.parametrize("controller", CONTROL_SCHEMES)
def test_contact_is_regrasped_from_forearm_to_hand(controller):
    """The last of the forearm and the first of the hand."""
    path = ((0.205, 0.195), (0.20, 0.10))
    session = Session(two_links(), settings=replace(LINE, controller=controller, path=path))
    trip = Trip(session, 8.1)  # the force has settled again after the landing
    bounded(trip)
    assert trip.states == [State.PLAN, State.LIFT, State.CARRY, State.PRESS]
    assert LimitKind.REGRASP_MOVES in trip.why
    assert trip.piece[-1] == 1
    assert trip.link[-1] == "hand"
    assert trip.last(trip.force).mean() == pytest.approx(3.0, abs=0.25)


@pytest.mark.long
def test_contact_is_held_if_the_new_place_is_blocked():
    """Touched on the hand, with a path drawn on the forearm: where that touches, the ball is in another link."""
    prepared = two_links()
    hand = near(prepared, 1, [0.03, 0.0, 0.06])
    far = near(prepared, 0, [-0.05, 0.0, 0.02])
    start = prepared.map.taxel_points[far]
    session = pressed_by_ball(
        replace(LINE, path=on_map(prepared, far, start + [0.0, 0.02])), prepared=prepared, taxel=hand
    )
    trip = Trip(session, 7.0)
    bounded(trip)
    assert trip.states == [State.PLAN]
    [failed] = [limit for limit in session.frame.why_limited if limit.kind is LimitKind.REGRASP_FAILED]
    assert (failed.names, failed.cause) == (("hand", "forearm"), RegraspFailure.BLOCKED)
    assert "ball" in failed.between
    assert set(trip.link) == {"hand"}
    assert trip.last(trip.force) == pytest.approx(3.0, abs=0.2)
    assert np.ptp(trip.last(trip.posture), axis=0).max() < 0.01, "it stays"


@pytest.mark.long
def test_arm_returns_home_if_the_object_leaves_during_a_regrasp():
    path = ((0.205, 0.195), (0.20, 0.10))
    taxel = int(np.linalg.norm(two_links().map.taxel_points - path[0], axis=1).argmin())
    way = ((0.0, 0.0), (1.5, 0.0), (2.0, 0.15), (60.0, 0.15))
    trip = Trip(pressed_by_ball(replace(LINE, path=path), prepared=two_links(), taxel=taxel, way=way), 20.0)
    bounded(trip)
    assert trip.states == [
        State.PLAN,
        State.LIFT,
        State.CARRY,
        State.PRESS,
        State.RETURN,
        State.FAILED,
    ]
    assert LimitKind.REGRASP_RETURNS in trip.why
    home = trip.session.prepared.robot.home
    assert trip.posture[-1] == pytest.approx(home, abs=0.05)


@pytest.mark.long
def test_changed_path_continues_at_the_contact():
    prepared = forearm()
    start = prepared.map.taxel_points[150]
    lines = [on_map(prepared, start, start + np.array([0.03, up])) for up in (0.0, 0.008)]
    session = pressed_by_ball(replace(LINE, path=lines[0], path_speed=0.01))
    first = Trip(session, 2.0)
    session.submit(ControlChanged(replace(session.settings, path=lines[1])))
    second = Trip(session, 3.0)
    bounded(first)
    bounded(second)
    assert second.way[0] == pytest.approx(first.way[-1], abs=0.006)
    assert np.abs(second.force[:40] - 3.0).max() < 1.0, "without a step in the contact force"
    assert np.nanmedian(second.body_error) < 0.005


@pytest.mark.long
def test_drawn_path_keeps_its_place_when_patches_are_moved():
    """The path stays where it was drawn on the map; the contact is led to where that is on the skin now."""
    prepared = forearm()
    start = prepared.map.taxel_points[150]
    session = pressed_by_ball(replace(LINE, path=on_map(prepared, start, start + [0.03, 0.0]), path_speed=0.01))
    Trip(session, 1.5)
    [placement] = prepared.map.layout.placements
    offset = (placement.offset[0], placement.offset[1] + 0.01)
    moved = TactileMap(prepared.skin, prepared.map.charts, MapLayout((replace(placement, offset=offset),)))
    session.submit(MapEdited("Move the patch", moved))
    trip = Trip(session, 3.0)
    bounded(trip)
    assert np.abs(trip.force[:40] - 3.0).max() < 2.0, "the contact starts at once with 40 mm/s"
    assert trip.way[0] == pytest.approx(0.015, abs=0.008)
    assert session.frame.regions[0].map_point[1] == pytest.approx(start[1], abs=0.008)
