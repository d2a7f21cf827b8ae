"""Automatic covers: valid requests, chosen links and the resulting skin."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import Finding, MeshError, RobotError, SkinError
from tactile_maps.geometry.remesh.wrap import wrap_mesh
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.points import nearest_others
from tactile_maps.robots.files.mesh_files import box_mesh
from tactile_maps.robots.load import load_robot_file
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.fitting.cover import (
    JOINT_CLEARANCE,
    MAX_COVER_TAXELS,
    NO_ROOM,
    CoverCandidate,
    CoverSpec,
    choose_links,
    cover_candidates,
    cover_robot,
    hull_area,
)
from tests.hard_cases.meshes import HARD_MESHES, HOPELESS_MESHES, one_link
from tests.support.example_robots import two_rods
from tests.support.findings import kinds, only


@pytest.mark.parametrize("taxels", [-1, 3, MAX_COVER_TAXELS + 1])
def test_implausible_taxel_counts_are_rejected(taxels):
    with pytest.raises(SkinError, match=f"found: {taxels}"):
        CoverSpec(taxels=taxels)


@pytest.mark.parametrize("thickness", [0.0, -1.0, 1.0, float("nan")])
def test_implausible_thicknesses_are_rejected(thickness):
    with pytest.raises(SkinError, match="thickness"):
        CoverSpec(thickness=thickness)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"margin": -0.001}, r"margin is out of range.*Choose 0 to 0.1 m"),
        ({"pitch": float("nan")}, r"pitch is out of range.*nan m"),
        ({"pattern": "grid"}, r"unknown pattern.*hexagonal"),
        ({"density": "high"}, r"unknown density.*uniform or curvature"),
        ({"axes": 2}, r"axes: invalid number of axes .found: 2.*Choose 1"),
        ({"density": "curvature", "pattern": "hexagonal"}, "only the even pattern"),
    ],
)
def test_invalid_placement_of_a_cover_is_rejected(values, message):
    with pytest.raises(SkinError, match=message):
        CoverSpec(**values)


def test_pitch_that_places_too_many_taxels_is_rejected_with_the_finest_possible_one():
    with pytest.raises(
        SkinError, match=r"pitch: the pitch places more than 20,000 taxels.*at least ([\d.]+) mm"
    ) as error:
        cover_robot(two_rods(), CoverSpec(("upper",), pitch=0.0005))
    finest = 1e-3 * float(re.search(r"at least ([\d.]+) mm", str(error.value))[1])
    area = hull_area(two_rods().link("upper").mesh)
    assert finest**2 * np.sqrt(3) / 2 * MAX_COVER_TAXELS == pytest.approx(area, rel=0.01)


@pytest.mark.parametrize("pattern", ["even", "hexagonal"])
def test_each_taxel_of_a_cover_has_the_area_that_follows_from_the_pitch(pattern):
    (patch,) = cover_robot(two_rods(), CoverSpec(("upper",), pitch=0.012, pattern=pattern)).patches
    assert patch.surface.area / len(patch.taxels) == pytest.approx(np.sqrt(3) / 2 * 0.012**2, rel=0.01)


@pytest.mark.long
def test_pads_of_modules_on_a_cover_keep_their_pitch():
    skin = cover_robot(two_rods(), CoverSpec(("upper",), pitch=0.012, pattern="modules"))
    distances, _ = nearest_others(skin.patches[0].taxels.positions, 1)
    assert np.median(distances) == pytest.approx(0.012, rel=0.1)  # chords of a bent module are shorter
    assert len(skin) % 10 == 0


@pytest.mark.long
def test_links_too_small_for_a_module_are_reported_and_stay_bare():
    spec = CoverSpec(("base", "upper"), pattern="modules", pitch=0.07)
    with pytest.raises(SkinError, match="no module fits"):
        cover_robot(two_rods(), spec)
    robot = two_rods(length=0.05)
    skin = cover_robot(robot, replace(spec, pitch=0.03))
    assert {patch.link for patch in skin.patches} == {"base"}
    assert only(skin.findings, "no-room").where == "upper"


@pytest.mark.parametrize("pattern", ["even", "hexagonal"])
def test_taxels_of_a_cover_with_three_axes_measure_shear_along_the_map(pattern):
    skin = cover_robot(two_rods(), CoverSpec(("upper",), taxels=60, pattern=pattern, axes=3))
    assert skin.three_axis.all()
    assert np.isnan(skin.tangents).all()


@pytest.mark.long
def test_cover_is_denser_where_the_surface_is_curved():
    surface_of = {}
    for density in ("uniform", "curvature"):
        patch = cover_robot(two_rods(), CoverSpec(("upper",), taxels=300, density=density)).patches[0]
        high = patch.taxels.positions[:, 2] > 0.29  # the rounded rim and the flat end
        surface_of[density] = int(high.sum())
    assert surface_of["curvature"] > 1.2 * surface_of["uniform"]


@pytest.mark.long
def test_cover_keeps_its_margin_from_other_links():
    for margin in (0.0, 0.03):
        skin = cover_robot(two_rods(), CoverSpec(("upper",), taxels=200, margin=margin))
        assert skin.patches[0].surface.vertices[:, 2].min() == pytest.approx(margin, abs=0.006)


@pytest.mark.parametrize(
    "other",
    [
        {"links": ("upper",)},
        {"taxels": 50},
        {"pitch": 0.03},
        {"thickness": 0.015},
        {"margin": 0.02},
        {"bare": ("upper",)},
    ],
)
def test_surface_of_an_equal_robot_is_made_again_only_if_the_cover_needs_another(monkeypatch, other):
    cover = CoverSpec(("base", "upper"), taxels=40, thickness=0.012)
    first = cover_robot(two_rods(), cover)
    wrapped = []

    def wrap(mesh, **how):
        wrapped.append(how["where"])
        return wrap_mesh(mesh, **how)

    monkeypatch.setattr("tactile_maps.skin.fitting.cover.wrap_mesh", wrap)
    again = cover_robot(two_rods(), replace(cover, seed=1))
    assert wrapped == []
    assert [patch.surface.area for patch in again.patches] == [patch.surface.area for patch in first.patches]
    cover_robot(two_rods(), replace(cover, **other))
    assert wrapped == [*other.get("links", cover.links)]


def test_areas_of_an_equal_robot_are_not_computed_again(monkeypatch):
    first = cover_candidates(two_rods())
    monkeypatch.setattr("tactile_maps.skin.fitting.cover._exposed_area", lambda *_of_a_link: 0.0)
    assert cover_candidates(two_rods()) == first
    base, upper, frame = two_rods().links
    larger = replace(upper, mesh=Mesh(2 * upper.mesh.vertices, upper.mesh.faces))
    assert not any(found.area for found in cover_candidates(replace(two_rods(), links=(base, larger, frame))))


def test_candidates_are_all_links_with_the_area_and_the_reason_against_a_cover():
    lost = without_meshes(two_rods(), "upper")
    base, upper, frame = cover_candidates(two_rods())
    assert (base.link, base.moves, base.reason) == ("base", False, "")
    assert upper.area == pytest.approx(hull_area(two_rods().link("upper").mesh), rel=0.1)
    assert upper.moves
    assert (base.parent, upper.parent) == ("", "base")
    assert frame == CoverCandidate("frame", 0.0, False, "it has no shape", "base")
    quick = cover_candidates(two_rods(), measured=False)
    assert [(found.link, found.moves, found.reason, found.area) for found in quick] == [
        (found.link, found.moves, found.reason, 0.0) for found in (base, upper, frame)
    ]
    assert cover_candidates(lost)[1] == CoverCandidate("upper", 0.0, True, "its mesh file is missing", "base")


@pytest.mark.parametrize(
    ("shape", "size", "exact"),
    [
        ("capsule", "0.05 0.15", 2 * np.pi * 0.05 * 0.3 + 4 * np.pi * 0.05**2),
        ("cylinder", "0.06 0.1", 2 * np.pi * 0.06 * 0.2 + 2 * np.pi * 0.06**2),
        ("box", "0.04 0.03 0.05", 8 * (0.04 * 0.03 + 0.03 * 0.05 + 0.04 * 0.05)),
    ],
)
def test_area_of_a_candidate_does_not_depend_on_the_order_of_its_faces(tmp_path, shape, size, exact):
    rod = f'<body name="rod"><joint/><geom type="{shape}" size="{size}"/></body>'
    block = '<geom type="box" size="0.5 0.5 0.5" pos="0 0 -0.5"/>'
    (tmp_path / "rod.xml").write_text(f'<mujoco><worldbody><body name="block">{block}{rod}</body></worldbody></mujoco>')
    candidates = {found.link: found.area for found in cover_candidates(load_robot_file(tmp_path / "rod.xml"))}
    assert candidates["rod"] == pytest.approx(exact / 2, rel=0.03), "half of it is in the block"


def test_only_links_that_move_are_chosen():
    assert choose_links(two_rods()) == ("upper",)


LEG = """<body name="{n}_thigh" pos="{x} {y} 0"><joint axis="1 0 0"/><joint axis="0 1 0"/>
  <geom type="capsule" size=".04" fromto="0 0 -.02 {bend} 0 -.25"/>
  <body name="{n}_shin" pos="{bend} 0 -.3"><joint axis="0 1 0"/><geom type="capsule" size=".02" fromto="0 0 0 0 0 -.2"/>
  </body></body>"""


def quadruped(tmp_path, more=""):
    """A trunk on a slide with four equal legs of three joints; the front ones are bent forward in the home posture."""
    places = {"fl": (0.3, 0.2), "fr": (0.3, -0.2), "hl": (-0.3, 0.2), "hr": (-0.3, -0.2)}
    legs = "".join(LEG.format(n=n, x=x, y=y, bend=0.02 if n[0] == "f" else 0.0) for n, (x, y) in places.items())
    trunk = f'<body name="trunk"><joint type="slide"/><geom type="box" size=".4 .15 .1"/>{legs}{more}</body>'
    (tmp_path / "dog.xml").write_text(f"<mujoco><worldbody>{trunk}</worldbody></mujoco>")
    return load_robot_file(tmp_path / "dog.xml")


@pytest.mark.long
def test_equal_links_are_all_chosen_or_none(tmp_path):
    assert choose_links(quadruped(tmp_path)) == ("fl_thigh", "fr_thigh", "hl_thigh", "hr_thigh")


def test_limbs_are_chosen_before_larger_heads_boxes_and_trunks(tmp_path):
    parts = """<body name="head_1" pos="0 0 .3"><joint axis="0 0 1"/><joint axis="0 1 0"/>
      <geom type="box" size=".2 .2 .2"/></body>
      <body name="battery_box" pos="0 0 -.4"><joint axis="0 0 1"/><joint axis="0 1 0"/>
      <geom type="box" size=".2 .2 .2"/></body>"""
    robot = quadruped(tmp_path, parts)
    largest = sorted(cover_candidates(robot), key=lambda candidate: -candidate.area)[:3]
    assert {candidate.link for candidate in largest} == {"trunk", "head_1", "battery_box"}
    assert choose_links(robot) == ("fl_thigh", "fr_thigh", "hl_thigh", "hr_thigh")


def without_meshes(robot, *names):
    """Return the robot with small boxes in place of the meshes of some links, like a robot with missing files."""
    box = Mesh(box_mesh(0.02).vertices + [0, 0, 0.15], box_mesh(0.02).faces)
    return replace(
        robot,
        links=tuple(replace(link, mesh=box, missing=("rod",)) if link.name in names else link for link in robot.links),
    )


def test_placeholder_of_a_missing_mesh_is_not_chosen():
    robot = two_rods()
    assert "upper" not in choose_links(without_meshes(robot, "upper"))
    with pytest.raises(SkinError, match=r"all links.*missing.*found: .*upper.*name the links"):
        choose_links(without_meshes(robot, *robot.link_index))
    notes = (
        Finding("unnamed", "joints", "named"),
        Finding("missing-mesh", "a/rod.stl", "left; similar files: rod.obj"),
    )
    with pytest.raises(SkinError, match=r"found: .*frame; a/rod\.stl: left; similar files: rod\.obj\)"):
        choose_links(replace(without_meshes(robot, *robot.link_index), findings=notes))


@pytest.mark.long
def test_placeholder_of_a_missing_mesh_is_covered_only_if_its_link_is_named():
    lost = without_meshes(two_rods(), "upper")
    chosen = cover_robot(lost, CoverSpec(taxels=60))
    assert "upper" not in {patch.link for patch in chosen.patches}
    assert "placeholder-covered" not in kinds(chosen.findings)
    named = cover_robot(lost, CoverSpec(links=("upper",), taxels=60, thickness=0.001))
    assert [finding.where for finding in named.findings if finding.kind == "placeholder-covered"] == ["upper"]


FINGER = """<body name="{n}_0" pos="{x} 0 .05">
  <joint axis="1 0 0"/><geom type="box" size=".01 .01 .009" pos="0 0 .009"/>
  <body name="{n}_1" pos="0 0 .018"><joint axis="1 0 0"/><geom type="box" size=".011 .011 .013" pos="0 0 .013"/>
  <body name="{n}_2" pos="0 0 .026"><joint axis="1 0 0"/><geom type="box" size=".009 .009 .009" pos="0 0 .009"/>
  </body></body></body>"""


@pytest.fixture
def hand(tmp_path):
    """Three short fingers on a palm: their middle links are the largest ones that move, and have no room for skin."""
    fingers = "".join(FINGER.format(n=n, x=x) for n, x in (("a", -0.03), ("b", 0.0), ("c", 0.03)))
    palm = f'<body name="palm"><geom type="box" size=".045 .015 .05"/>{fingers}</body>'
    (tmp_path / "hand.xml").write_text(f"<mujoco><worldbody>{palm}</worldbody></mujoco>")
    return load_robot_file(tmp_path / "hand.xml")


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("taxels", "covered"), [(600, ["a_2", "b_2", "c_2"]), (60, ["palm"])])
def test_other_links_are_covered_if_the_chosen_ones_have_no_room(hand, taxels, covered):
    """Patches on the tips would have too few taxels."""
    assert choose_links(hand) == ("a_1", "b_1", "c_1")
    skin = cover_robot(hand, CoverSpec(taxels=taxels))
    assert len(skin) == taxels
    assert sorted({patch.link for patch in skin.patches}) == covered
    finding = only(skin.findings, "other-links")
    assert finding.where == ", ".join(covered)
    assert "a_1, b_1, c_1" in finding.action


def test_named_links_without_room_are_rejected(hand):
    with pytest.raises(SkinError, match=r"hand.xml, a_1: no surface is left.*Choose other links"):
        cover_robot(hand, CoverSpec(links=("a_1",), taxels=60))


def reasons(robot, spec):
    return {note.where: note.action for note in cover_robot(robot, spec).findings if note.kind == NO_ROOM}


@pytest.mark.parametrize(
    ("margin", "reason"),
    [
        (0.01, r"only [\d.]+ cm² are clear of other links and visible, 12 taxels need 63 cm²"),
        (0.03, "other links are closer than the margin of 30 mm everywhere"),
    ],
)
def test_links_without_taxels_state_the_reason(hand, margin, reason):
    assert re.search(reason, reasons(hand, CoverSpec(("palm", "a_2"), taxels=60, margin=margin))["a_2"])


def test_piece_below_the_least_share_of_its_link_is_stated():
    """Only the flat end of the rod is clear of the base."""
    found = reasons(two_rods(buried=0.185, length=0.2), CoverSpec(("base", "upper"), taxels=300))
    assert re.search(r"visible, a piece is at least 15 % of its surface, [\d.]+ cm²", found["upper"])


def test_link_that_others_hide_is_stated(tmp_path):
    """A ball in the middle of a box of six plates."""
    plates = "".join(
        f'<geom type="box" size="{" ".join(".005" if k == axis else ".1" for k in range(3))}"'
        f' pos="{" ".join(str(side) if k == axis else "0" for k in range(3))}"/>'
        for axis in range(3)
        for side in (-0.1, 0.1)
    )
    ball = '<body name="ball"><geom type="sphere" size=".05"/></body>'
    text = f'<mujoco><worldbody><body name="box">{plates}</body>{ball}</worldbody></mujoco>'
    (tmp_path / "box.xml").write_text(text)
    found = reasons(load_robot_file(tmp_path / "box.xml"), CoverSpec(("box", "ball"), taxels=200))
    assert found == {"ball": "not covered: the parts that are clear of other links are hidden from outside"}


def test_robot_without_joints_is_covered_on_any_link():
    assert choose_links(one_link(HARD_MESHES["cube"])) == ("part",)


def test_robot_without_geometry_is_rejected():
    bare = Robot(
        "bare", "bare.xml", '<mujoco><worldbody><body name="b"/></worldbody></mujoco>', {}, (), (), np.zeros(0)
    )
    with pytest.raises(SkinError, match="geometry"):
        choose_links(bare)


def test_hull_area_of_a_cube_is_its_area_and_of_a_plate_one_side():
    assert hull_area(HARD_MESHES["cube"]) == pytest.approx(HARD_MESHES["cube"].area)
    assert hull_area(HARD_MESHES["flat plate"]) == pytest.approx(0.06)
    assert hull_area(Mesh(np.eye(3), [[0, 1, 2]])) == pytest.approx(np.sqrt(3) / 2)


@pytest.mark.long
def test_cover_is_clear_of_the_joint_and_has_the_requested_number():
    skin = cover_robot(two_rods(buried=0.05), CoverSpec(("base", "upper"), taxels=101))
    assert len(skin) == 101
    assert [(patch.name, patch.link) for patch in skin.patches] == [("base", "base"), ("upper", "upper")]
    upper = skin.patches[1].surface.vertices
    assert upper[:, 2].min() > 0.05 + 0.5 * JOINT_CLEARANCE, "the base reaches 50 mm up the rod"


@pytest.mark.long
def test_taxels_are_distributed_by_area():
    skin = cover_robot(two_rods(), CoverSpec(("base", "upper"), taxels=200))
    density = [len(patch.taxels) / patch.surface.area for patch in skin.patches]
    assert density[0] == pytest.approx(density[1], rel=0.03)


@pytest.mark.long
def test_progress_is_reported_and_may_cancel():
    class Cancelled(Exception):
        pass

    found = []
    cover_robot(two_rods(), CoverSpec(taxels=50), progress=lambda text, done: found.append((text, done)))
    assert found[0] == ("Covering upper", 0.0)
    assert [done for _, done in found] == sorted(done for _, done in found)

    def cancel(_text, _done):
        raise Cancelled

    with pytest.raises(Cancelled):
        cover_robot(two_rods(), CoverSpec(taxels=50), progress=cancel)


def test_unknown_link_and_one_without_geometry_are_named():
    with pytest.raises(RobotError, match="elbow"):
        cover_robot(two_rods(), CoverSpec(("elbow",)))
    with pytest.raises(SkinError, match="found: frame"):
        cover_robot(two_rods(), CoverSpec(("frame",)))


@pytest.mark.parametrize("name", HOPELESS_MESHES)
def test_link_with_zero_area_raises_a_clear_error(name):
    with pytest.raises((SkinError, MeshError), match=r"part.*area|geometry.*part"):
        cover_robot(one_link(HOPELESS_MESHES[name]), CoverSpec(("part",), taxels=20))


def test_link_hidden_in_its_neighbour_stays_bare():
    with pytest.raises(SkinError, match="no surface is left"):
        cover_robot(two_rods(buried=0.15, length=0.1), CoverSpec(("upper",), taxels=20))


@pytest.mark.long
def test_repairs_are_reported():
    skin = cover_robot(one_link(HARD_MESHES["duplicates"]), CoverSpec(taxels=20))
    assert {finding.kind for finding in skin.findings} == {"duplicate-vertex", "duplicate-face"}
    assert np.isfinite(skin.areas).all()
