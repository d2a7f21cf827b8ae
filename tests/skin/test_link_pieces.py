"""Convex pieces of links whose hull would span hollows of their skin."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from tactile_maps.core.files import FOLDER_VARIABLE
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.link_pieces import (
    BARE_AREA,
    PIECES_SUFFIX,
    PROUD,
    PROUD_AREA,
    collision_finding,
    hull_fit,
    link_pieces,
    piece_link,
    piece_name,
    piece_number,
    pieces_fit,
)
from tests.support.hollows import BASE, HALF, hollow, raised
from tests.support.touch import bar, bar_skin, pair

HOLLOWS = ("bowl", "groove", "saddle")


@pytest.mark.sampled(2)
@pytest.mark.parametrize("shape", HOLLOWS)
@pytest.mark.parametrize("solid", [True, False], ids=["solid", "skin alone"])
def test_collision_pieces_follow_a_concave_skin(shape, solid):
    robot, skin = hollow(shape, solid=solid)
    before = hull_fit(robot, skin, "block")
    assert before.largest > 0.02
    assert before.share > 0.3
    pieces = link_pieces(robot, skin, "block")
    after = pieces_fit(pieces, robot, skin, "block")
    assert after.largest < 0.6e-3, "0.5 % of 120 mm"
    assert after.usual < 0.4e-3
    assert after.angle < np.radians(12)
    assert len(pieces.hulls) < 150


def test_pieces_follow_skin_and_bare_link_where_the_skin_is_raised():
    robot, skin = raised()
    before = hull_fit(robot, skin, "block")
    assert before.largest < 1e-9, "the skin is convex"
    assert before.bare == pytest.approx(3e-3, rel=0.05)
    assert before.bare_share > BARE_AREA
    finding = collision_finding(robot, "block", before, None)
    assert (finding.kind, finding.where) == ("collision-shape", "block")
    assert finding.action == "it collides as its convex hull, up to 3.0 mm above the bare link next to its skin"
    pieces = link_pieces(robot, skin, "block")
    after = pieces_fit(pieces, robot, skin, "block")
    assert max(after.largest, after.bare) < 1e-6
    assert collision_finding(robot, "block", after, pieces) is None
    facets = [ConvexHull(hull).equations for hull in pieces.hulls]
    for x, height in ((0.03, 3e-3), (2e-3, 3e-3), (-1e-4, 0.0), (-0.02, 0.0), (-0.05, 0.0)):
        for off, expected in ((-2e-4, True), (2e-4, False)):
            place = np.array([x, 0.011, height + off])
            assert any((f[:, :3] @ place + f[:, 3] < 0).all() for f in facets) is expected, (x, off)


@pytest.mark.parametrize(("height", "reported"), [(2e-4, False), (5e-4, True), (8e-4, True)])
def test_hull_of_slightly_raised_skin_is_reported(height, reported):
    """Pieces follow the surface within 0.36 mm on a link of this size."""
    robot, skin = raised(height)
    fit = hull_fit(robot, skin, "block")
    assert link_pieces(robot, skin, "block") is None
    finding = collision_finding(robot, "block", fit, None)
    assert (finding is not None) is reported
    if reported:
        assert finding.action.endswith(f"up to {1e3 * height:.1f} mm above the bare link next to its skin")


def test_hull_of_slightly_hollow_skin_is_reported():
    robot, skin = hollow("groove")
    top = skin.patches[0].surface
    shallow = Mesh(top.vertices * [1, 1, 0.04], top.faces)
    skin = replace(skin, patches=(replace(skin.patches[0], surface=shallow),))
    robot = replace(robot, links=(replace(robot.links[0], missing=("block.stl",)),))
    assert link_pieces(robot, skin, "block") is None
    finding = collision_finding(robot, "block", hull_fit(robot, skin, "block"), None)
    assert finding.action == "it collides as its convex hull, up to 0.7 mm above its skin", "in the middle of faces"


def opened(robot, *, turned=False, inner=False):
    """Return a block without its bottom.

    Args:
        robot: The block.
        turned: All faces look inward.
        inner: A box is inside.
    """
    whole = robot.links[0].mesh
    mesh = Mesh(whole.vertices, whole.faces[whole.corners.max(axis=1)[:, 2] > BASE + 1e-6])
    if inner:
        box = 0.5 * whole.vertices + [0, 0, -0.005]
        mesh = Mesh(np.concatenate([mesh.vertices, box]), np.concatenate([mesh.faces, whole.faces + len(box)]))
    if turned:
        mesh = Mesh(mesh.vertices, mesh.faces[:, ::-1])
    return replace(robot, links=(replace(robot.links[0], mesh=mesh),))


@pytest.mark.sampled(1)
@pytest.mark.parametrize("kind", [{}, {"turned": True}, {"inner": True}], ids=["open", "turned", "inner"])
def test_bare_part_of_an_open_mesh_is_measured_and_followed(kind):
    robot, skin = raised()
    robot = opened(robot, **kind)
    before = hull_fit(robot, skin, "block")
    assert before.bare == pytest.approx(3e-3, rel=0.05)
    assert before.bare_share > BARE_AREA
    pieces = link_pieces(robot, skin, "block")
    after = pieces_fit(pieces, robot, skin, "block")
    assert after.largest < 1e-6
    assert after.bare < PROUD, "a wrap is not exact"
    assert collision_finding(robot, "block", after, pieces) is None


def test_bare_parts_that_cannot_collide_are_reported():
    """The mesh of the link has no area to wrap, so that the skin alone collides."""
    robot, skin = hollow("bowl")
    degenerate = Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]]))
    robot = replace(robot, links=(replace(robot.links[0], mesh=degenerate),))
    pieces = link_pieces(robot, skin, "block")
    finding = collision_finding(robot, "block", pieces_fit(pieces, robot, skin, "block"), pieces)
    assert (finding.kind, finding.where) == ("bare-part-open", "block")


@pytest.mark.parametrize(("robot", "skin"), [hollow("flat"), (bar(), bar_skin()), pair()])
def test_links_with_convex_skin_collide_as_their_hull(robot, skin):
    for link in skin.links:
        assert hull_fit(robot, skin, link).share <= PROUD_AREA
        assert link_pieces(robot, skin, link) is None


def test_pieces_stay_in_the_block_and_cover_its_bare_sides():
    pieces = link_pieces(*hollow("groove"), "block")
    points = np.concatenate(pieces.hulls)
    assert np.abs(points[:, :2]).max() < HALF + 2e-3
    assert points[:, 2].min() > BASE - 2e-3
    inner = [ConvexHull(hull).equations for hull in pieces.hulls]
    for place in ((0.0, 0.0, BASE + 3e-3), (HALF - 3e-3, 0.0, -0.025), (0.03, HALF - 3e-3, -0.02)):
        assert any((facets[:, :3] @ place + facets[:, 3] < 0).all() for facets in inner), place


@pytest.mark.long
def test_pieces_do_not_protrude_from_a_thin_wall():
    """A bowl as thin as a shell: pieces are at most half as thick."""
    robot, skin = hollow("bowl")
    top = skin.patches[0].surface
    below = Mesh(top.vertices - [0, 0, 1e-3], top.faces[:, ::-1])
    shell = replace(skin.patches[0], surface=top)
    under = replace(skin.patches[0], name="under", surface=below)
    pieces = link_pieces(
        replace(robot, links=(replace(robot.links[0], missing=("x",)),)), replace(skin, patches=(shell, under)), "block"
    )
    fit = pieces_fit(pieces, robot, replace(skin, patches=(shell, under)), "block")
    assert fit.largest < 1e-3


@pytest.mark.long
def test_every_skin_face_is_in_a_piece_and_the_result_is_deterministic(monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, "off")
    robot, skin = hollow("bowl")
    first = link_pieces(replace(robot), skin, "block")
    assert (first.piece >= 0).all()
    assert set(first.piece.tolist()) == set(range(len(first.hulls)))
    for number in (0, len(first.hulls) - 1):
        corners = first.surface.vertices[first.surface.faces[first.piece == number]].reshape(-1, 3)
        facets = ConvexHull(first.hulls[number]).equations
        assert (corners @ facets[:, :3].T + facets[:, 3]).max() < 1e-9
    assert link_pieces(replace(robot), skin, "block") is first, "a robot of the same shape shares the pieces"
    monkeypatch.setattr("tactile_maps.skin.link_pieces._MADE", {})
    again = link_pieces(replace(robot), skin, "block")
    assert again is not first
    assert all(np.array_equal(one, other) for one, other in zip(first.hulls, again.hulls, strict=True))


@pytest.mark.long
def test_pieces_are_kept_on_disk_bit_for_bit(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "kept"))
    robot, skin = hollow("groove")
    made = link_pieces(replace(robot), skin, "block")
    (entry,) = (tmp_path / "kept").iterdir()
    assert entry.suffix == PIECES_SUFFIX
    kept = entry.read_bytes()
    found = link_pieces(replace(robot), skin, "block")
    assert found is not made
    assert entry.read_bytes() == kept
    for one, other in ((made, found),):
        assert one.skinned == other.skinned
        assert np.array_equal(one.piece, other.piece)
        assert np.array_equal(one.surface.vertices, other.surface.vertices)
        assert all(np.array_equal(a, b) for a, b in zip(one.hulls, other.hulls, strict=True))
    entry.write_bytes(kept[:100])
    again = link_pieces(replace(robot), skin, "block")
    assert np.array_equal(again.piece, made.piece), "a damaged entry is made again"
    assert entry.read_bytes() == kept
    other_skin = replace(
        skin, patches=(replace(skin.patches[0], surface=hollow("groove", cells=22)[1].patches[0].surface),)
    )
    link_pieces(replace(robot), other_skin, "block")
    assert len(list((tmp_path / "kept").iterdir())) == 2, "another skin"


@pytest.mark.long
def test_least_recently_used_pieces_are_deleted_above_the_folder_limit(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    (robot, skin), (other, other_skin) = hollow("groove"), hollow("groove", cells=22)
    link_pieces(replace(robot), skin, "block")
    (first,) = tmp_path.iterdir()
    os.utime(first, (1.0, 1.0))
    monkeypatch.setattr("tactile_maps.skin.link_pieces._MOST_KEPT", int(1.5 * first.stat().st_size))
    link_pieces(replace(other), other_skin, "block")
    (left,) = tmp_path.iterdir()
    assert left != first


def test_names_of_pieces_state_link_and_number():
    assert (piece_number(piece_name("left arm", 12)), piece_link(piece_name("left arm", 12))) == (12, "left arm")
    assert (piece_number("left arm"), piece_link("left arm")) == (None, "left arm")
