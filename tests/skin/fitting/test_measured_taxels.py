from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from tactile_maps.core.errors import RobotError, SkinError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.files.mesh_files import box_mesh
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.load import load_robot_file
from tactile_maps.skin.fitting.grid import GridSpec, grid_skin
from tactile_maps.skin.fitting.measured_taxels import place_taxels
from tactile_maps.skin.model.taxel_axes import tangents_on
from tactile_maps.skin.model.taxel_set import TaxelSet
from tests.hard_cases.meshes import HOPELESS_MESHES, one_link
from tests.support.example_robots import two_rods
from tests.support.findings import by_kind, kinds, only


def sleeve(heights, *, angles=None):
    """Positions on the upper rod, 6 mm apart."""
    angles = np.arange(0, 2 * np.pi, 0.15) if angles is None else angles
    angle, height = (grid.ravel() for grid in np.meshgrid(angles, heights))
    return np.stack([0.04 * np.cos(angle), 0.04 * np.sin(angle), height], axis=1)


def fitted(robot, link, positions, thickness=0.001):
    taxels = TaxelSet("hand", link, np.arange(len(positions)), positions, ids=10 + np.arange(len(positions)))
    return place_taxels(robot, link, taxels, thickness=thickness, file="hand.txt")


def on_rod(positions, robot=None):
    return fitted(robot or two_rods(), "upper", positions, thickness=0.002)


@pytest.mark.long
def test_two_separate_groups_are_two_patches():
    skin = on_rod(np.concatenate([sleeve(np.arange(0.05, 0.10, 0.006)), sleeve(np.arange(0.2, 0.22, 0.006))]))
    assert [patch.name for patch in skin.patches] == ["upper", "upper 2"]
    for patch in skin.patches:
        assert patch.surface.connectivity.components.max() == 0
        assert len(patch.surface.connectivity.boundary_loops) == 2
        assert patch.taxels.areas.sum() <= patch.surface.area * (1 + 1e-12)


@pytest.mark.long
def test_taxels_closer_than_the_face_size_have_an_area():
    angles = np.arange(0, 1.2, 0.15)  # a part of the way round: all faces are as fine as the nearest pair asks for
    rings, near = (sleeve(np.array(heights), angles=angles) for heights in ([0.1, 0.106, 0.112], [0.1002]))
    positions = np.concatenate([rings, near])
    (patch,) = on_rod(positions, two_rods(length=0.13)).patches
    assert len(patch.taxels) == len(positions)
    assert (patch.taxels.areas > 0).all()


def test_isolated_taxel_is_a_patch():
    (patch,) = on_rod(np.array([[0.04, 0, 0.15]])).patches
    assert len(patch.taxels) == 1


@pytest.mark.long
def test_positions_in_the_links_other_frame_are_found():
    robot = two_rods()
    shift = np.array([0.0, 0.0, 0.4])
    mjcf = robot.mjcf.replace("</body><body name=", '<body name="upper_dh_frame" pos="0 0 0.4"/></body><body name=')
    links = (*robot.links[:2], replace(robot.links[2], name="upper_dh_frame"), robot.links[2])
    other = replace(robot, mjcf=mjcf, links=links)
    positions = sleeve(np.arange(0.05, 0.10, 0.006))
    here = on_rod(positions, other)
    there = on_rod(positions - shift, other)
    assert "taxel-frame" not in kinds(here.findings)
    assert "taxel-frame" in kinds(there.findings)
    assert there.patches[0].taxels.positions == pytest.approx(here.patches[0].taxels.positions, abs=1e-9)


PALM = """<mujoco model="palm"><worldbody>
  <body name="palm"><geom type="box" size=".04 .04 .015"/>
    <body name="palm_frame" pos="0 0 .015"/>
    <body name="tip" pos="0 0 .06"><joint name="bend" axis="0 1 0" range="-60 60"/>
      <geom type="cylinder" size=".004 .025"/>
      <body name="rubber" pos="0 0 .01" euler="0 0 30"><geom type="cylinder" size=".012 .015"/></body>
      <body name="nail" pos="0 0 -.02"><joint name="slip" type="slide" range="0 0.001"/>
        <geom type="cylinder" size=".012 .002"/></body></body></body>
  </worldbody></mujoco>"""


@pytest.fixture
def palm(tmp_path):
    """A finger tip with a thin core, rubber fixed on it, a nail that moves, and a frame without shape on the palm."""
    (tmp_path / "palm.xml").write_text(PALM)
    return load_robot_file(tmp_path / "palm.xml")


def ring(radius, heights):
    angle, height = (grid.ravel() for grid in np.meshgrid(np.arange(0, 2 * np.pi, 0.6), heights))
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)


def test_taxels_are_fitted_to_the_links_fixed_to_theirs(palm):
    positions = ring(0.012, np.array([0.0, 0.008, 0.016]))
    skin = fitted(palm, "tip", positions)
    assert {patch.link for patch in skin.patches} == {"rubber"}
    assert len(skin) == len(positions)
    turn = np.deg2rad(30)
    turned = positions @ [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    found = np.concatenate([patch.taxels.positions for patch in skin.patches])
    assert np.linalg.norm(found - (turned - [0, 0, 0.01]), axis=1).max() < 0.003
    findings = by_kind(skin.findings)
    assert findings["taxel-distance"].action == "stated on the link's mesh, kept on its cover"
    assert (findings["rigid-link"].where, findings["rigid-link"].count) == ("tip", len(positions))
    assert "rubber" in findings["rigid-link"].action


def test_taxels_stated_for_a_link_without_shape_are_on_the_link_it_is_fixed_to(palm):
    grid = np.stack(np.meshgrid(np.arange(-0.02, 0.021, 0.01), np.arange(-0.02, 0.021, 0.01), [0.0]), axis=-1)
    (patch,) = fitted(palm, "palm_frame", grid.reshape(-1, 3)).patches
    assert patch.link == "palm"
    assert patch.taxels.positions[:, 2] == pytest.approx(0.015 + 0.001, abs=5e-4)


def test_taxels_are_not_fitted_to_links_beyond_a_joint(palm):
    skin = fitted(palm, "tip", ring(0.012, np.array([-0.021, -0.019])))
    assert {patch.link for patch in skin.patches} == {"tip"}


LINK_CASES = [(0.0, 0.0, True), (0.0015, 0.0, False), (0.005, 0.003, False)]


@pytest.mark.parametrize(
    ("height", "off", "stays"),
    [
        (0.0008, 0.0, True),
        (0.005, 0.007, True),
        *(pytest.param(*case, marks=pytest.mark.long) for case in LINK_CASES),
    ],
)
def test_taxels_change_to_a_link_that_is_clearly_closer_and_at_most_half_as_far(palm, height, off, stays):
    """A sheet is ``height`` [m] above the palm; taxels of the palm are ``off`` [m] above the sheet."""
    corners = [[x, y, height] for x, y in ((-0.03, -0.03), (0.03, -0.03), (0.03, 0.03), (-0.03, 0.03))]
    sheet = Mesh(corners, [[0, 1, 2], [0, 2, 3]])
    links = tuple(replace(link, mesh=sheet) if link.name == "palm_frame" else link for link in palm.links)
    side = np.arange(-0.02, 0.021, 0.01)
    grid = np.stack(np.meshgrid(side, side, [0.015 + height + off]), axis=-1)
    skin = fitted(replace(palm, links=links), "palm", grid.reshape(-1, 3))
    assert {patch.link for patch in skin.patches} == {"palm" if stays else "palm_frame"}


BOXES = """<mujoco model="boxes"><worldbody><body name="core"><geom type="box" size="{core}" pos="0 0 {shift}"/>
  <body name="pad" pos="0 0 .01" euler="0 0 90"><geom type="box" size="{pad}" pos="0 0 -.01"/></body></body></worldbody>
  </mujoco>"""
SIDE = np.arange(-0.012, 0.0121, 0.006)


def boxes(tmp_path, core, pad, shift=0.0):
    """A core and a pad fixed around it, whose frame is another; sizes are halves."""
    (tmp_path / "boxes.xml").write_text(BOXES.format(core=core, pad=pad, shift=shift))
    return load_robot_file(tmp_path / "boxes.xml")


def in_core(robot, skin, link):
    """Positions of the taxels on a link, in the frame of the core."""
    positions = [patch.taxels.positions for patch in skin.patches if patch.link == link]
    x, y, z = np.concatenate(positions).T
    return np.stack([-y, x, z + 0.01], axis=1) if link == "pad" else np.stack([x, y, z], axis=1)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("stated", ["core", "pad"])
@pytest.mark.parametrize("depth", [0.0005, 0.002, 0.006, 0.012])
def test_taxels_in_a_pad_move_to_its_surface_instead_of_the_core(tmp_path, stated, depth):
    """The taxels are stated a tenth of the pad's depth above the core."""
    robot = boxes(tmp_path, ".02 .02 .02", " ".join([str(0.02 + depth)] * 3))
    grid = np.stack(np.meshgrid(SIDE, SIDE, [0.02 + 0.1 * depth]), axis=-1).reshape(-1, 3)
    positions = grid if stated == "core" else np.stack([grid[:, 1], -grid[:, 0], grid[:, 2] - 0.01], axis=1)
    skin = fitted(robot, stated, positions)
    assert {patch.link for patch in skin.patches} == {"pad"}
    found = in_core(robot, skin, "pad")
    assert found[:, 2] == pytest.approx(0.02 + depth + 0.001, abs=2e-4)
    assert found[:, :2] == pytest.approx(grid[:, :2], abs=5e-4)


def test_taxels_at_a_core_protruding_from_its_pad_are_on_the_touchable_surface(tmp_path):
    """The core is out of the pad above 30 mm; taxels are inside the pad near the core, and on the core outside."""
    robot = boxes(tmp_path, ".02 .02 .04", ".035 .035 .03", shift=0.02)
    across, up = np.meshgrid(SIDE, [0.0, 0.006, 0.012, 0.028, 0.042, 0.048, 0.054])
    positions = np.stack([np.where(up > 0.03, 0.02, 0.024).ravel(), across.ravel(), up.ravel()], axis=1)
    skin = fitted(robot, "core", positions)
    assert len(skin) == len(positions)
    out = in_core(robot, skin, "core")
    assert len(out) == 3 * len(SIDE)
    assert out[:, 2].min() > 0.04
    assert out[:, 0] == pytest.approx(0.021, abs=2e-4)
    inside = in_core(robot, skin, "pad")
    on_side = np.abs(inside[:, 0] - 0.036) < 2e-4
    on_top = np.abs(inside[:, 2] - 0.031) < 2e-4
    assert (on_side | on_top).all()
    assert (on_side.sum(), on_top.sum()) == (3 * len(SIDE), len(SIDE))


def test_taxels_between_a_plate_and_its_base_move_to_the_outer_side_of_the_plate(tmp_path):
    robot = boxes(tmp_path, ".03 .03 .01", ".03 .03 .005", shift=-0.015)
    grid = np.stack(np.meshgrid(SIDE, SIDE, [-0.004]), axis=-1).reshape(-1, 3)
    skin = fitted(robot, "core", grid)
    assert {patch.link for patch in skin.patches} == {"pad"}
    assert in_core(robot, skin, "pad")[:, 2] == pytest.approx(0.006, abs=2e-4)


def cylinder(radius, height):
    solid = trimesh.creation.cylinder(radius, height, sections=96)
    return np.asarray(solid.vertices), np.asarray(solid.faces)


def lost(robot, *names):
    """Return the robot with small boxes in place of the meshes of some links, like a robot with missing files."""
    box = box_mesh(0.02)
    links = (replace(link, mesh=box, missing=("shell",)) if link.name in names else link for link in robot.links)
    return replace(robot, links=tuple(links))


SHEET = np.stack(np.meshgrid([0.05, 0.06, 0.07], [0.0, 0.01, 0.02], [0.01]), axis=-1).reshape(-1, 3)


@pytest.mark.parametrize(("link", "missing"), [("tip", ["tip"]), ("tip", ["tip", "rubber"]), ("palm_frame", ["palm"])])
def test_taxels_keep_their_positions_if_the_mesh_is_missing(palm, link, missing):
    skin = fitted(lost(palm, *missing), link, SHEET)
    (patch,) = skin.patches
    assert patch.link == link
    order = np.argsort(patch.taxels.identity.ids)
    assert patch.taxels.positions[order] == pytest.approx(SHEET)
    finding = only(skin.findings, "stated-places")
    assert (finding.where, finding.count) == (link, len(SHEET))


ON_TIP = ring(0.0045, np.array([-0.02, -0.016]))
"""Half a millimetre from the core of the tip."""


def at_stated_places(skin, positions):
    """Return whether each position, with the ids of ``fitted``, has a taxel exactly there."""
    ids = np.concatenate([patch.taxels.identity.ids for patch in skin.patches])
    found = np.concatenate([patch.taxels.positions for patch in skin.patches])[np.argsort(ids)]
    assert sorted(ids) == list(range(10, 10 + len(positions)))
    return np.linalg.norm(found - positions, axis=1) < 1e-9


def without_a_mesh(robot, name, place):
    """The robot with a link that has other shapes than its missing mesh, at ``place`` [m]."""
    box = box_mesh(0.02)
    boxes = (Mesh(box.vertices + place, box.faces),)
    return replace(robot, links=tuple(replace(o, left_out=boxes) if o.name == name else o for o in robot.links))


@pytest.mark.parametrize("missing", ["placeholder", "own", "fixed to it"])
def test_only_taxels_on_the_missing_mesh_keep_their_positions(palm, missing):
    near_box = ring(0.0105, np.array([0.008, 0.012]))  # half a millimetre from the box, 6 mm from the tip
    positions = np.concatenate([ON_TIP, near_box, SHEET])
    robot = lost(palm, "rubber")
    if missing == "own":
        robot = without_a_mesh(replace(palm, links=palm.links[:3] + lost(palm).links[4:]), "tip", [0, 0, 0.01])
    elif missing == "fixed to it":
        links = tuple(replace(link, mesh=None) if link.name == "rubber" else link for link in palm.links)
        robot = without_a_mesh(replace(palm, links=links), "rubber", [0, 0, 0])
    skin = fitted(robot, "tip", positions)
    assert {patch.link for patch in skin.patches} == {"tip"}
    stays = at_stated_places(skin, positions)
    assert stays.tolist() == [False] * len(ON_TIP) + [True] * (len(near_box) + len(SHEET))
    findings = by_kind(skin.findings)
    assert (findings["stated-places"].where, findings["stated-places"].count) == ("tip", stays.sum())
    assert findings["taxel-distance"].count == len(ON_TIP)


@pytest.mark.long
def test_taxels_on_existing_surfaces_are_fitted_though_a_mesh_is_missing(palm):
    skin, whole = (fitted(robot, "tip", ON_TIP) for robot in (without_a_mesh(palm, "tip", [0.1, 0, 0]), palm))
    assert "stated-places" not in kinds(skin.findings)
    assert skin.patches[0].taxels.positions == pytest.approx(whole.patches[0].taxels.positions)


@pytest.mark.parametrize("other", [False, True])
def test_places_of_a_missing_mesh_are_in_the_frame_that_fits_the_other_shapes(palm, other):
    turn = Pose(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([0, 0, 0.2]))
    positions = np.concatenate([*[ON_TIP] * other, SHEET])
    positions += np.arange(len(positions))[:, None] * 1e-5
    stated = turn.inverse.points(positions) if other else positions
    up = np.tile([1.0, 0, 0], (len(positions), 1))
    taxels = TaxelSet("hand", "tip", np.arange(len(stated)), stated, normals=up)
    frame = turn if other else Pose(np.eye(3), np.array([-0.015, 0, 0]))  # closer, yet far from every shape
    robot = without_a_mesh(palm, "tip", [0, 0, 0.1])
    skin = place_taxels(robot, "tip", taxels, file="hand.txt", frames={"other": frame})
    found = np.concatenate([patch.taxels.positions for patch in skin.patches])
    assert cKDTree(found).query(positions[-len(SHEET) :])[0].max() < 1e-9
    assert ("taxel-frame" in kinds(skin.findings)) == other


def test_normals_of_unfitted_taxels_are_in_the_frame_of_the_link(palm):
    turn = Pose(np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]), np.zeros(3))
    down = np.tile(turn.inverse.directions(np.array([0.0, 0, -1])), (len(ON_TIP) + len(SHEET), 1))
    stated = turn.inverse.points(np.concatenate([ON_TIP, SHEET]))
    taxels = TaxelSet("hand", "tip", np.arange(len(stated)), stated, normals=down)
    skin = place_taxels(
        without_a_mesh(palm, "tip", [0, 0, 0.1]), "tip", taxels, file="hand.txt", frames={"turned": turn}
    )
    (sheet,) = [patch for patch in skin.patches if len(patch.taxels) == len(SHEET)]
    assert sheet.taxels.normals == pytest.approx(np.tile([0, 0, -1], (len(SHEET), 1)))


def three_axis(positions, frame=None):
    """Return taxels in a frame; each second one has three axes, and all have the tangent (0.6, 0.8, 0) of the link."""
    back = (frame or Pose.identity()).inverse
    tangents = back.directions(np.tile([0.6, 0.8, 0.0], (len(positions), 1)))
    rows = np.arange(len(positions))
    axes = np.where(rows % 2, 3, 1)
    return TaxelSet("hand", "tip", rows, back.points(positions), ids=rows, axes=axes, tangents=tangents)


def assert_frames_follow(patch, pose):
    """Check axes, and tangents (0.6, 0.8, 0) of the link that carries ``patch`` at ``pose``."""
    taxels = patch.taxels
    assert taxels.axes.tolist() == np.where(taxels.identity.ids % 2, 3, 1).tolist()
    stated = np.tile(pose.inverse.directions(np.array([0.6, 0.8, 0.0])), (len(taxels), 1))
    np.testing.assert_allclose(taxels.tangents, tangents_on(stated, taxels.normals), atol=1e-9)


def test_tangents_of_fitted_taxels_are_in_the_frame_of_the_link_that_carries_them(palm):
    skin = place_taxels(palm, "tip", three_axis(ring(0.012, np.array([0.0, 0.008, 0.016]))), file="hand.txt")
    assert [patch.link for patch in skin.patches] == ["rubber"]
    assert_frames_follow(skin.patches[0], Configuration(palm).pose("tip").inverse @ Configuration(palm).pose("rubber"))


def test_tangents_of_unfitted_taxels_are_in_the_frame_of_the_link(palm):
    turn = Pose(np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]), np.zeros(3))
    taxels = three_axis(np.concatenate([ON_TIP, SHEET]), turn)
    robot = without_a_mesh(palm, "tip", [0, 0, 0.1])
    skin = place_taxels(robot, "tip", taxels, file="hand.txt", frames={"turned": turn})
    assert any(len(patch.taxels) == len(SHEET) for patch in skin.patches)
    for patch in skin.patches:
        assert_frames_follow(patch, Pose.identity())


def test_grid_on_a_placeholder_is_reported(palm):
    spec = GridSpec("palm", 3, 3, (-0.005, -0.005, 0.01), (0.005, 0.005, 0.01))
    kinds = {finding.kind for finding in grid_skin(lost(palm, "palm"), spec, thickness=0.001).findings}
    assert "placeholder-covered" in kinds


def test_taxels_far_from_the_link_are_rejected():
    with pytest.raises(SkinError, match=r"hand.txt.*20 mm from the link upper.*median"):
        on_rod(sleeve(np.array([0.1])) * [2, 2, 1])


def test_unknown_or_empty_link_is_rejected():
    with pytest.raises(RobotError, match="elbow"):
        fitted(two_rods(), "elbow", np.zeros((1, 3)))
    with pytest.raises(SkinError, match="no geometry"):
        fitted(one_link(HOPELESS_MESHES["no faces"]), "part", np.zeros((1, 3)))


@pytest.mark.long
def test_single_taxels_off_the_surface_are_named_with_their_distances():
    """Taxels 6 mm apart; the distance that all others have is not named."""
    positions = sleeve(np.arange(0.05, 0.10, 0.006)) * [1.05, 1.05, 1]
    assert "taxel-off-surface" not in kinds(on_rod(positions).findings)
    positions[[3, 40], :2] *= np.array([1.18, 1.36])[:, None]
    finding = by_kind(on_rod(positions).findings)["taxel-off-surface"]
    assert (finding.where, finding.count) == ("upper", 2)
    assert re.search(r": id 50 by 17\.\d mm, id 13 by 9\.\d mm$", finding.action)
