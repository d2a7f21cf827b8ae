"""A place for a weight: level, free, and where the skin is what it rests on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.errors import SimulationError
from app.geometry.mesh import Mesh
from app.robots.configuration import Configuration
from app.simulation.level_place import level_place
from app.skin.place import place_taxels
from app.skin.skin import Patch, Skin
from tests.touch import arm, bar, bar_skin

RADIUS = 0.03


def test_on_a_level_bar_the_weight_starts_just_above_the_skin():
    at, middle = level_place(bar(), bar_skin(), radius=RADIUS)
    assert np.allclose(bar_skin().position(at)[:2], middle[:2])
    assert 0 < middle[2] - RADIUS - 0.02 < 0.0005


def test_on_an_arm_it_faces_up_and_nothing_is_near():
    robot, skin = arm().robot, arm().skin
    at, middle = level_place(robot, skin, radius=RADIUS)
    kinematics = Configuration(robot)
    pose = kinematics.pose(skin.link(at))
    assert pose.directions(skin.normal(at))[2] > 0.98
    assert 0 < middle[2] - RADIUS - pose.points(skin.position(at))[2] < 0.004
    for link in robot.links:
        if link.mesh is not None and link.name != skin.link(at):
            points = kinematics.pose(link.name).points(link.mesh.vertices)
            assert np.linalg.norm(points - middle, axis=1).min() > RADIUS


def test_the_weight_avoids_what_hangs_over_the_skin():
    """A roof over most of the bar: the weight goes to the only place under the sky."""
    robot = bar(hinged=False)
    link = robot.links[0]
    roof = Mesh(link.mesh.vertices * [0.7, 1.0, 1.0] + [0.06, 0.0, 0.08], link.mesh.faces)
    covered = replace(robot, links=(link, replace(link, name="roof", mesh=roof)),
                      mjcf=robot.mjcf.replace("</worldbody>", '<body name="roof"/></worldbody>'))  # fmt: skip
    at, middle = level_place(covered, bar_skin(), radius=RADIUS)
    left, right = roof.bounds[0, 0] - RADIUS, roof.bounds[1, 0] + RADIUS
    assert not left < middle[0] < right
    assert bar_skin().position(at)[0] == pytest.approx(middle[0])
    everywhere = replace(covered, links=(link, replace(link, name="roof", mesh=Mesh(
        link.mesh.vertices * [1.5, 2.0, 1.0] + [-0.1, 0.0, 0.08], link.mesh.faces))))  # fmt: skip
    with pytest.raises(SimulationError, match="level and free"):
        level_place(everywhere, bar_skin(), radius=RADIUS)


def test_where_the_hull_stands_off_the_skin_it_does_not_lie():
    """A ridge beside the skin holds the hull above it."""
    robot = bar(hinged=False)
    link = robot.links[0]
    ridged = Mesh(np.concatenate([link.mesh.vertices, [[0.0, 0.05, 0.1], [0.4, 0.05, 0.1], [0.0, -0.05, 0.1],
                                                       [0.4, -0.05, 0.1]]]), link.mesh.faces)  # fmt: skip
    with pytest.raises(SimulationError, match=r"level and free.*faces up by 1\.00"):
        level_place(replace(robot, links=(replace(link, mesh=ridged),)), bar_skin(), radius=RADIUS)


def test_where_no_skin_faces_up_it_says_so():
    plate = bar_skin().patches[0].surface
    for turned in (Mesh(plate.vertices, plate.faces[:, ::-1]), Mesh(plate.vertices[:, [0, 2, 1]], plate.faces)):
        skin = Skin((Patch("side", "bar", turned, place_taxels(turned, 20, seed=0)),))
        with pytest.raises(SimulationError, match=r"no place on the skin lies level.*faces up by 0\.00"):
            level_place(bar(), skin, radius=RADIUS)
    with pytest.raises(SimulationError, match="no place on the skin"):
        level_place(bar(), Skin(()), radius=RADIUS)


def test_a_link_that_is_all_skin_and_flat_is_named():
    robot = bar(hinged=False)
    bare = replace(robot, links=(replace(robot.links[0], mesh=None),))
    with pytest.raises(SimulationError, match="too flat"):
        level_place(bare, bar_skin(), radius=RADIUS)
