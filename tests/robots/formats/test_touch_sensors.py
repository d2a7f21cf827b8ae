"""Touch sensors as an MJCF file states them: their places, links and directions; no plug-in is loaded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tactile_maps.core.errors import RobotError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.files.mesh_files import box_mesh
from tactile_maps.robots.formats.touch_sensors import TouchSensor, read_touch_sensors, states_touch_sensors

MODEL = """<mujoco><compiler angle="degree"/>
<extension><plugin plugin="mujoco.sensor.touch_grid">
  <instance name="shared"><config key="size" value="3 1"/><config key="fov" value="90 30"/></instance>
</plugin></extension>
<default><default class="pad"><site type="box" size="0.01 0.002 0.01"/></default></default>
<asset><mesh name="ball" builtin="sphere" params="1" scale="0.02 0.02 0.02"/></asset>
<worldbody><site name="floor" pos="0 0 0"/>
  <body name="hand" pos="1 0 0" euler="0 0 90"><joint/>
    <geom name="palm" size="0.05 0.05 0.01" type="box" pos="0 0 0.1"/>
    <frame pos="0 0 0.05"><site class="pad" name="front" pos="0 0.01 0" euler="90 0 0"/></frame>
    <body name="tip" pos="0 0 0.2"><joint axis="1 0 0"/><geom size="0.02"/><site name="eye" euler="180 0 0"/></body>
  </body><body><geom size="0.1"/><site name="plain"/></body>
</worldbody>
<sensor><jointpos joint="absent"/><touch name="t" site="front"/><touch site="floor"/>
  <plugin name="grid" plugin="mujoco.sensor.touch_grid" objtype="site" objname="eye">
    <config key="size" value="2 2"/><config key="fov" value="90 60"/><config key="nchannel" value="3"/></plugin>
  <plugin name="second" instance="shared" objtype="site" objname="eye"/>
  <tactile name="skin" geom="palm" mesh="ball"/><touch name="lost" site="nowhere"/><touch name="bare" site="plain"/>
  <plugin plugin="third.party" objtype="site" objname="eye"/>
</sensor></mujoco>"""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "hand.xml"
    path.write_text(MODEL)
    return path


def test_sensors_are_read_in_order_with_their_links(model):
    sensors, findings = read_touch_sensors(model)
    assert [(s.name, s.kind, s.link, len(s.origins)) for s in sensors] == [
        ("t", "touch", "hand", 1),
        ("grid", "touch_grid", "tip", 4),
        ("second", "touch_grid", "tip", 3),
        ("skin", "tactile", "hand", 42),
    ]
    (left,) = findings
    assert (left.where, left.count) == ("touch 1, lost, bare", 3)


def test_site_is_located_in_its_link_with_frames_and_classes(model):
    touch, _, _, tactile = read_touch_sensors(model)[0]
    assert touch.origins == pytest.approx(np.array([[0, 0.01, 0.05]]))
    assert touch.directions is None
    assert np.linalg.norm(tactile.origins - [0, 0, 0.1], axis=1) == pytest.approx(np.full(42, 0.02), rel=1e-5)


def test_grid_with_three_channels_has_tangents_along_the_x_axis_of_its_site(model):
    touch, grid, second, tactile = read_touch_sensors(model)[0]
    np.testing.assert_allclose(grid.t1, np.tile([1.0, 0.0, 0.0], (4, 1)), atol=1e-9)
    assert [one.t1 for one in (touch, second, tactile)] == [None] * 3


def test_rays_of_a_grid_are_along_minus_z_up_to_its_fov_on_either_side(model):
    _, grid, second, _ = read_touch_sensors(model)[0]
    assert grid.directions is not None
    assert second.directions is not None
    turned = grid.directions * [1, -1, -1]  # the site is turned about x by half a turn
    azimuth = np.arctan2(turned[:, 0], -turned[:, 2])
    elevation = np.arcsin(turned[:, 1])
    assert np.degrees(azimuth) == pytest.approx([-45, 45, -45, 45])
    assert np.degrees(elevation) == pytest.approx([-30, -30, 30, 30])
    assert second.directions[1] == pytest.approx([0, 0, 1], abs=1e-9)


def test_grid_with_gamma_is_finer_in_the_middle(model):
    size = '<config key="size" value="2 2"/>'
    gamma = '<config key="size" value="4 1"/><config key="gamma" value="0.5"/>'
    model.write_text(MODEL.replace(size, gamma))
    directions = read_touch_sensors(model)[0][1].directions
    assert directions is not None
    azimuth = np.degrees(np.arctan2(directions[:, 0], directions[:, 2]))
    # the edge at 0.5: 0.5 * 0.5**5 + 0.5 * 0.5
    outer = 90 * (1 + 0.265625) / 2
    inner = 90 * 0.265625 / 2
    assert azimuth == pytest.approx([-outer, -inner, inner, outer])


def test_ray_ends_where_it_leaves_the_link():
    sensor = TouchSensor("g", "touch_grid", "a", np.zeros((2, 3)), np.array([[0.0, 0, 1], [0.6, 0, 0.8]]))
    assert sensor.places(box_mesh(0.2)) == pytest.approx(np.array([[0, 0, 0.1], [0.075, 0, 0.1]]))
    away = Mesh(box_mesh(0.2).vertices + [0, 0, -5], box_mesh(0.2).faces)
    assert np.linalg.norm(sensor.places(away), axis=1) == pytest.approx([0.02, 0.02]), "nothing there"


def test_sensors_of_included_files_are_detected(model):
    assert states_touch_sensors(model)
    (model.parent / "whole.xml").write_text('<mujoco><include file="hand.xml"/></mujoco>')
    assert states_touch_sensors(model.parent / "whole.xml")
    model.write_text(MODEL.replace("<sensor>", "<!--").replace("</sensor>", "-->"))
    assert not states_touch_sensors(model)
    assert not states_touch_sensors(model.parent / "absent.xml")


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("size", "2"),
        ("size", "0 2"),
        ("size", "9999 9999"),
        ("fov", "x y"),
        ("fov", "90 91"),
        ("fov", "181 60"),
        ("fov", "nan 60"),
    ],
)
def test_invalid_grid_is_rejected_by_name(model, key, value):
    old = {"size": "2 2", "fov": "90 60"}[key]
    model.write_text(MODEL.replace(f'key="{key}" value="{old}"', f'key="{key}" value="{value}"'))
    with pytest.raises(RobotError, match="touch grid") as found:
        read_touch_sensors(model)
    assert "sensor grid" in str(found.value)
