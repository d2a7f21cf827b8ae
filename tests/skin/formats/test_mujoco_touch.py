"""MuJoCo's touch sensors as a skin, and a skin as MuJoCo's sensors: what presses a taxel is read by its sensor."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from tactile_maps.cli.commands.inspect import describe
from tactile_maps.cli.parser import build_parser
from tactile_maps.cli.shared.scenes import scene_from_arguments
from tactile_maps.core.errors import SkinError
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.taxel_frames import taxel_frames
from tactile_maps.robots.library import load_robot
from tactile_maps.robots.load import load_robot_file
from tactile_maps.scene.scene_file import scene_for, scene_for_taxels
from tactile_maps.session.prepare import load_robot_and_skin, open_scene
from tactile_maps.skin.formats import mujoco_touch
from tactile_maps.skin.formats.identify import is_robot_with_taxels, kind_of
from tactile_maps.skin.formats.import_skin import TaxelFile
from tactile_maps.skin.formats.mujoco_touch import write_touch_sensors
from tactile_maps.skin.model.skin import Skin, taxels_with_axes
from tactile_maps.skin.model.taxel_axes import tangents_on
from tactile_maps.skin.open import SkinOptions, open_skin
from tactile_maps.skin.taxel_placement.placement import PlacementSpec
from tactile_widgets.__main__ import main
from tests.support.findings import kinds

PLATE = """<mujoco model="plate"><worldbody><body name="plate" pos="0 0 0.5">
  <geom name="plate" type="box" size="0.06 0.06 0.01"/>SITES</body>
  <body name="toy" pos="1 0 0"><freejoint/><geom size="0.01"/><site name="toy"/></body>
  <body name="arm" pos="0 0.5 0.5"><joint name="j" axis="0 1 0"/><geom size="0.05"/></body>
</worldbody>SENSORS</mujoco>"""


def plate(folder, *, sensors):
    places = [(x, y) for x in (-0.03, 0, 0.03) for y in (-0.03, 0, 0.03)]
    sites = "".join(f'<site name="s{i}" pos="{x} {y} 0.008" size="0.005"/>' for i, (x, y) in enumerate(places))
    touch = "".join(f'<touch name="t{i}" site="s{i}"/>' for i in reversed(range(9)))
    folder.mkdir(exist_ok=True)
    path = folder / "plate.xml"
    stated = f'<sensor>{touch}<touch name="again" site="s4"/></sensor>' if sensors else ""
    path.write_text(PLATE.replace("SITES", sites).replace("SENSORS", stated))
    return path


def test_touch_sites_become_taxels_numbered_as_their_sensors(tmp_path):
    skin = open_skin(plate(tmp_path, sensors=True))
    assert len(skin) == 9
    assert {patch.link for patch in skin.patches} == {"plate"}
    ids = skin.patches[0].taxels.identity.ids
    places = skin.patches[0].taxels.positions
    assert sorted(ids) == list(range(9))
    last = places[list(ids).index(0)]
    assert last == pytest.approx([0.03, 0.03, 0.013], abs=1e-3), "the last site is the first sensor's"
    notes = {(finding.kind, finding.where): finding for finding in skin.findings}
    assert "t8, t7" in notes["touch-sensor", "plate"].action
    assert notes["duplicate-taxel", "plate"].count == 1
    names = skin.patches[0].taxels.identity.names
    assert names[list(ids).index(0)] == "t8", "each is called as its sensor"
    assert notes["duplicate-taxel", "plate"].action.partition(":")[0] not in names


@pytest.mark.long
def test_free_body_with_a_touch_sensor_is_a_link_with_a_taxel(tmp_path):
    path = plate(tmp_path, sensors=True)
    path.write_text(path.read_text().replace("</sensor>", '<touch site="toy"/></sensor>'))
    skin = open_skin(path)
    assert [(patch.link, len(patch.taxels)) for patch in skin.patches] == [("plate", 9), ("toy", 1)]
    other = load_robot_file(plate(tmp_path / "other", sensors=True))
    assert "toy" not in other.link_index
    notes = {finding.where: finding for finding in TaxelFile(path).skin(other).findings}
    assert notes["touch 10"].action == "left out: its body is not a link of the robot"


def with_frames(folder, frames):
    """Return a model whose plate has a <tactile> sensor with these (n, t1, t2) at nine vertices."""
    places = [(x, y, 0.001 * (x == y)) for x in (-0.03, 0, 0.03) for y in (-0.03, 0, 0.035)]  # not in a plane
    vertices, normals = (" ".join(map(str, np.ravel(values))) for values in (places, 9 * list(frames)))
    mesh = f'<asset><mesh name="pad" inertia="shell" vertex="{vertices}" normal="{normals}"/></asset>'
    path = plate(folder, sensors=False)
    geom = '<geom name="pad" type="mesh" mesh="pad" pos="0 0 0.01" mass="0" contype="0" conaffinity="0"/>'
    stated = path.read_text().replace("<worldbody>", f"{mesh}<worldbody>")
    stated = stated.replace('<geom name="plate"', f'{geom}<geom name="plate"')
    path.write_text(stated.replace("</mujoco>", '<sensor><tactile name="s" geom="pad" mesh="pad"/></sensor></mujoco>'))
    return path


FRAME = np.array([[0.0, 0.0, 1.0], [0.6, 0.8, 0.0], [-0.8, 0.6, 0.0]])


def test_tactile_sensor_with_three_normals_at_each_vertex_has_three_axes(tmp_path):
    skin = open_skin(with_frames(tmp_path, FRAME))
    assert (len(skin), skin.three_axis.all()) == (9, True)
    expected = tangents_on(np.tile(FRAME[1], (9, 1)), skin.patches[0].taxels.normals)
    np.testing.assert_allclose(skin.tangents, expected, atol=1e-6)
    plain = open_skin(with_frames(tmp_path, FRAME[:1]))
    assert not plain.three_axis.any()


def test_left_handed_tactile_sensor_is_rejected_by_name(tmp_path):
    with pytest.raises(SkinError, match="sensor s, taxel 0: the frame .* is left-handed .*Swap t1 and t2"):
        open_skin(with_frames(tmp_path, FRAME[[0, 2, 1]]))


SHELL = """<mujoco model="shell"><asset><mesh name="shell" file="shell.stl"/></asset><worldbody>
  <body name="base"><geom type="box" size=".05 .05 .05"/>
  <body name="arm" pos="0 0 .06"><joint name="j" axis="0 1 0" range="-60 60"/>{other}
    <geom name="shell" type="mesh" mesh="shell" mass=".5"/>{sites}<site name="eye" pos="0.05 0 0.1"/></body></body>
  </worldbody><sensor>{sensors}</sensor></mujoco>"""
SITES = [(0.05, y, z) for y in (0.0, 0.01, 0.02) for z in (0.10, 0.11)]


def shell(folder, *, sensors="", other=""):
    """A model with six touch sensors on a link whose mesh is missing."""
    sites = "".join(f'<site name="s{i}" pos="{x} {y} {z}" size="0.004"/>' for i, (x, y, z) in enumerate(SITES))
    touch = "".join(f'<touch name="t{i}" site="s{i}"/>' for i in range(len(SITES)))
    path = folder / "shell.xml"
    path.write_text(SHELL.format(sites=sites, sensors=sensors or touch, other=other))
    return path


def test_touch_sensors_stay_at_their_sites_if_the_mesh_is_missing(tmp_path):
    skin = open_skin(shell(tmp_path))
    (patch,) = skin.patches
    assert patch.link == "arm"
    assert patch.taxels.positions[np.argsort(patch.taxels.identity.ids)] == pytest.approx(np.array(SITES))
    kinds = {finding.kind for finding in skin.findings}
    assert {"missing-mesh", "stated-places"} <= kinds


@pytest.mark.long
def test_touch_sensors_beyond_the_other_shapes_stay_at_their_sites(tmp_path):
    """A small box is left of the link: it carries the sensor at its side, and none of those on the missing shell."""
    other = '<geom type="box" size=".01 .01 .01"/><site name="side" pos=".0101 0 0" size=".004"/>'
    path = shell(tmp_path, other=other)
    path.write_text(path.read_text().replace("</sensor>", '<touch name="t" site="side"/></sensor>'))
    skin = open_skin(path)
    places = {
        taxel: place
        for patch in skin.patches
        for taxel, place in zip(patch.taxels.identity.ids.tolist(), patch.taxels.positions, strict=True)
    }
    assert np.array([places[number] for number in range(6)]) == pytest.approx(np.array(SITES))
    assert places[6] == pytest.approx([0.013, 0, 0], abs=1e-3)
    counts = kinds(skin.findings)
    assert (counts["stated-places"], counts["missing-mesh"], counts["taxel-distance"]) == (6, 1, 1)


def test_touch_grid_ignores_the_placeholder_of_a_missing_mesh(tmp_path):
    config = '<config key="size" value="3 3"/><config key="fov" value="30 30"/>'
    grid = f'<plugin name="g" plugin="mujoco.sensor.touch_grid" objtype="site" objname="eye">{config}</plugin>'
    skin = open_skin(shell(tmp_path, sensors=grid))
    reach = np.linalg.norm(skin.patches[0].taxels.positions - [0.05, 0, 0.1], axis=1)
    assert len(reach) == 9
    assert reach == pytest.approx(np.full(9, 0.02))


def test_tactile_sensor_with_a_missing_mesh_is_omitted(tmp_path):
    touch = '<touch name="t0" site="s0"/><tactile name="felt" geom="shell" mesh="shell"/>'
    skin = open_skin(shell(tmp_path, sensors=touch))
    assert len(skin) == 1
    notes = {finding.where: finding.action for finding in skin.findings if finding.kind == "touch-sensor"}
    assert "mesh" in notes["felt"]
    assert "missing" in notes["felt"]


def test_touch_sensors_give_the_same_skin_through_every_interface(tmp_path):
    path = plate(tmp_path, sensors=True)
    expected = open_skin(path)
    own = tmp_path / "own.toml"
    own.write_text("robot = 'plate.xml'\ntaxel_file = 'plate.xml'")
    run = scene_from_arguments(build_parser().parse_args(["run", "--skin", str(path)]))
    assert (run.robot, run.taxel_files, run.title) == (str(path), (str(path),), "plate.xml with its own taxels")
    for scene in (open_scene(str(own)), run, scene_for_taxels(str(path))):
        skin = load_robot_and_skin(scene)[1]
        np.testing.assert_array_equal(skin.areas, expected.areas)
        np.testing.assert_array_equal(skin.identity.ids, expected.identity.ids)
    assert scene_for(str(path)).taxel_files == (), "an opened robot gets a cover, and its own sensors only on request"
    found = describe(str(path))
    assert (found["kind"], found["taxels"], found["touch_sensors"][:2]) == ("robot with taxels", 10, ["t8", "t7"])


def test_touch_sensors_without_their_own_robot_are_rejected(tmp_path):
    path = plate(tmp_path, sensors=True)
    assert is_robot_with_taxels(path, kind_of(path))
    bare = plate(tmp_path / "bare", sensors=False)
    assert not is_robot_with_taxels(bare, kind_of(bare))
    path = plate(tmp_path, sensors=True)
    with pytest.raises(SkinError, match=r"plate\.xml: touch sensors need their robot.*Open the file as the robot"):
        TaxelFile(path).skin()
    file = TaxelFile(path)
    for use in (file.skin, file.check_links):
        with pytest.raises(SkinError, match=r"none of the bodies with touch sensors.*plate"):
            use(load_robot("arm"))


@pytest.mark.long
def test_robot_is_covered_on_request_or_without_sensors(tmp_path):
    options = SkinOptions(PlacementSpec(taxels=30), links=("plate",), surface="cover")
    assert len(open_skin(plate(tmp_path, sensors=True), options)) == 30
    assert len(open_skin(plate(tmp_path, sensors=False), SkinOptions(PlacementSpec(taxels=20)))) == 20


def test_touch_sensors_only_on_another_link_are_rejected(tmp_path):
    with pytest.raises(SkinError, match="none of its touch sensors"):
        open_skin(plate(tmp_path, sensors=True), SkinOptions(links=("arm",)))


def test_exported_sensor_reads_the_force_on_its_taxel(tmp_path):
    model = plate(tmp_path, sensors=True)
    assert main(["map", str(model), "-o", str(tmp_path / "out.xml")]) == 0
    skin = open_skin(model)
    for taxel in (0, 4, 7):
        place = skin.patches[0].taxels.positions[taxel] + [0, 0, 0.5]
        spec = mujoco.MjSpec.from_file(str(tmp_path / "out.xml"))
        ball = spec.worldbody.add_body(pos=[place[0], place[1], 0.5201])
        ball.add_freejoint()
        ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.01, 0, 0], mass=0.1)
        compiled = spec.compile()
        data = mujoco.MjData(compiled)
        mujoco.mj_step(compiled, data, 500)
        read = np.array([data.sensor(f"taxel_{i}").data[0] for i in range(len(skin))])
        assert read[taxel] == pytest.approx(0.981, rel=0.05)
        assert np.delete(read, taxel) == pytest.approx(np.zeros(8), abs=1e-9)


def test_three_axis_taxels_are_written_as_sensors_of_the_whole_force_and_read_again(tmp_path):
    model = plate(tmp_path, sensors=True)
    (patch,) = open_skin(model).patches
    tangents = tangents_on(np.tile(FRAME[1], (9, 1)), patch.taxels.normals)
    skin = Skin((replace(patch, taxels=replace(taxels_with_axes(patch.taxels, 3), tangents=tangents)),))
    frames = taxel_frames(build_map(skin))
    with pytest.raises(SkinError, match=r"need frames.*taxel_frames"):
        write_touch_sensors(skin, load_robot_file(model), tmp_path / "out.xml")
    write_touch_sensors(skin, load_robot_file(model), tmp_path / "out.xml", frames=frames)
    again = open_skin(tmp_path / "out.xml")
    assert again.three_axis.all()
    np.testing.assert_allclose(again.patches[0].taxels.positions, patch.taxels.positions, atol=1e-4)
    np.testing.assert_allclose(again.tangents, frames[:, 0], atol=0.05)
    pull = np.array([0.3, -0.2, 0.0])
    for taxel in (0, 4, 7):
        spec = mujoco.MjSpec.from_file(str(tmp_path / "out.xml"))
        ball = spec.worldbody.add_body(pos=[*patch.taxels.positions[taxel, :2], 0.5201])
        for axis in np.eye(3):
            ball.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.01, 0, 0], mass=0.1, friction=[1, 0, 0])
        compiled = spec.compile()
        data = mujoco.MjData(compiled)
        data.qfrc_applied[-3:] = pull
        mujoco.mj_step(compiled, data, 200)
        read = np.stack([data.sensor(f"taxel_{k}").data for k in range(len(skin))])
        turn = data.site(f"taxel_{taxel}").xmat.reshape(3, 3)
        np.testing.assert_allclose(turn.T, frames[taxel], atol=1e-6)
        np.testing.assert_allclose(turn.T @ read[taxel], frames[taxel] @ (pull - [0, 0, 0.981]), atol=0.02)
        assert not np.delete(read, taxel, axis=0).any()


def test_tactile_sensor_of_mujoco_reads_the_speed_of_slip_and_no_traction(tmp_path):
    model = with_frames(tmp_path, FRAME)
    notes = {finding.kind: finding for finding in open_skin(model).findings}
    assert "speeds of slip along t1 and t2, not tractions" in notes["slip-channels"].action
    spec = mujoco.MjSpec.from_file(str(model))
    ball = spec.worldbody.add_body(pos=[0, 0, 0.5202])
    for axis in np.eye(3):
        ball.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.01, 0, 0], mass=0.1, friction=[1, 0, 0])
    compiled = spec.compile()
    data = mujoco.MjData(compiled)
    data.qfrc_applied[-3:] = [0.3, 0.0, -10.0]
    mujoco.mj_step(compiled, data, 300)
    for velocity in (np.zeros(3), np.array([0.06, 0.08, 0.0])):
        data.qvel[-3:] = velocity
        mujoco.mj_forward(compiled, data)
        depth, *slips = data.sensor("s").data.reshape(3, 9)
        touched = np.flatnonzero(depth > 0)
        assert len(touched)
        expected = np.abs(FRAME[1:] @ velocity)[:, None]
        np.testing.assert_allclose(np.array(slips)[:, touched], np.tile(expected, len(touched)), atol=1e-6)


@pytest.mark.long
def test_robot_of_meshes_is_written_with_its_meshes(tmp_path, monkeypatch):
    assert main(["map", "arm", "--links", "hand", "--taxels", "30", "-o", str(tmp_path / "arm.xml")]) == 0
    monkeypatch.chdir("/")
    compiled = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    assert compiled.nsensor == 30
    assert compiled.body(int(compiled.site_bodyid[0])).name == "hand"
    assert list((tmp_path / "arm_meshes").iterdir())
    again = open_skin(tmp_path / "arm.xml")
    assert len(again) == 30
    assert list(again.patches[0].taxels.identity.ids) == list(range(30))


def test_skin_of_another_robot_is_rejected(tmp_path):
    skin = open_skin(plate(tmp_path, sensors=True))
    other = tmp_path / "other.xml"
    other.write_text('<mujoco><worldbody><body name="b"><joint/><geom size="0.1"/></body></worldbody></mujoco>')
    with pytest.raises(SkinError, match="no link of the skin's"):
        write_touch_sensors(skin, load_robot_file(other), tmp_path / "out.xml")
    assert not (tmp_path / "out.xml").exists()


def test_too_many_rays_are_rejected(tmp_path, monkeypatch):
    path = plate(tmp_path, sensors=False)
    grid = (
        '<sensor><plugin plugin="mujoco.sensor.touch_grid" objtype="site" objname="s4"><config key="size" value="9 9"/>'
        '<config key="fov" value="90 90"/></plugin></sensor></mujoco>'
    )
    path.write_text(path.read_text().replace("</mujoco>", grid))
    assert len(open_skin(path)) == 81
    monkeypatch.setattr(mujoco_touch, "_MOST_RAY_TESTS", 900)
    with pytest.raises(SkinError, match="take too long"):
        open_skin(path)
