"""A weight finds a level place, and reads its weight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.simulation.known_load_check import find_level_place, weigh
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.support.touch import arm, bar, bar_skin

RADIUS = 0.03


def test_weight_on_a_level_bar_starts_just_above_the_skin():
    at, middle = find_level_place(bar(), bar_skin(), radius=RADIUS)
    assert np.allclose(bar_skin().position(at)[:2], middle[:2])
    assert 0 < middle[2] - RADIUS - 0.02 < 0.0005


def test_weight_on_an_arm_is_placed_on_a_level_clear_taxel():
    robot = arm().robot
    skin = arm().skin
    at, middle = find_level_place(robot, skin, radius=RADIUS)
    kinematics = Configuration(robot)
    pose = kinematics.pose(skin.link(at))
    assert pose.directions(skin.normal(at))[2] > 0.98
    assert 0 < middle[2] - RADIUS - pose.points(skin.position(at))[2] < 0.004
    for link in robot.links:
        if link.mesh is not None and link.name != skin.link(at):
            points = kinematics.pose(link.name).points(link.mesh.vertices)
            assert np.linalg.norm(points - middle, axis=1).min() > RADIUS


def test_weight_avoids_parts_overhanging_the_skin():
    """A roof over most of the bar: the weight goes to the only place under the sky."""
    robot = bar(hinged=False)
    link = robot.links[0]
    roof = Mesh(link.mesh.vertices * [0.7, 1.0, 1.0] + [0.06, 0.0, 0.08], link.mesh.faces)
    covered = replace(
        robot,
        links=(link, replace(link, name="roof", mesh=roof)),
        mjcf=robot.mjcf.replace("</worldbody>", '<body name="roof"/></worldbody>'),
    )
    at, middle = find_level_place(covered, bar_skin(), radius=RADIUS)
    left = roof.bounds[0, 0] - RADIUS
    right = roof.bounds[1, 0] + RADIUS
    assert not left < middle[0] < right
    assert bar_skin().position(at)[0] == pytest.approx(middle[0])
    everywhere = replace(
        covered,
        links=(
            link,
            replace(
                link, name="roof", mesh=Mesh(link.mesh.vertices * [1.5, 2.0, 1.0] + [-0.1, 0.0, 0.08], link.mesh.faces)
            ),
        ),
    )
    with pytest.raises(SimulationError, match="level and unobstructed"):
        find_level_place(everywhere, bar_skin(), radius=RADIUS)


def test_weight_is_not_placed_where_hull_and_skin_differ():
    """A ridge next to the skin keeps the hull above it."""
    robot = bar(hinged=False)
    link = robot.links[0]
    ridged = Mesh(np.concatenate([link.mesh.vertices, [[0.0, 0.05, 0.1], [0.4, 0.05, 0.1], [0.0, -0.05, 0.1],
                                                       [0.4, -0.05, 0.1]]]), link.mesh.faces)  # fmt: skip
    with pytest.raises(SimulationError, match=r"level and unobstructed.*faces up by 1\.00"):
        find_level_place(replace(robot, links=(replace(link, mesh=ridged),)), bar_skin(), radius=RADIUS)


def test_missing_upward_skin_is_reported():
    plate = bar_skin().patches[0].surface
    for turned in (Mesh(plate.vertices, plate.faces[:, ::-1]), Mesh(plate.vertices[:, [0, 2, 1]], plate.faces)):
        skin = Skin((Patch("side", "bar", turned, place_evenly(turned, 20, seed=0)),))
        with pytest.raises(SimulationError, match=r"no part of the skin is level.*faces up by 0\.00"):
            find_level_place(bar(), skin, radius=RADIUS)
    with pytest.raises(SimulationError, match="no part of the skin"):
        find_level_place(bar(), Skin(()), radius=RADIUS)


CONSERVING = ("point", "water-fill", "punch", "foundation")


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("model", CONSERVING)
@pytest.mark.parametrize("hinged", [False, True])
def test_mass_of_100_grams_reads_0_981_newton_on_a_level_bar(model, hinged):
    weighed = weigh(bar(hinged=hinged), bar_skin(), ElasticLayer(), model)
    assert weighed.expected_N == pytest.approx(0.981)
    assert weighed.read_N == pytest.approx(0.981, rel=0.01)
    assert weighed.error == pytest.approx(weighed.read_N / 0.981 - 1)
    assert (weighed.model, weighed.patch, weighed.place.patch) == (model, "top", 0)
    assert 0.1 < weighed.seconds < 5.0


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("model", CONSERVING)
def test_weight_is_measured_on_the_round_links_of_a_compliant_arm(model):
    prepared = arm()
    weighed = weigh(prepared.robot, prepared.skin, ElasticLayer(), model)
    assert weighed.read_N == pytest.approx(0.981, rel=0.01)
    patch = prepared.skin.patches[weighed.place.patch]
    normal = Configuration(prepared.robot).pose(patch.link).directions(prepared.skin.normal(weighed.place))
    assert normal[2] > 0.93, "it is where the skin is level"


@pytest.mark.parametrize(
    ("model", "mass", "words"),
    [("off", 0.1, "model.*off"), ("point", 0.0, "mass.*0 kg"), ("point", float("nan"), "mass.*nan")],
)
def test_invalid_weight_or_model_is_rejected(model, mass, words):
    with pytest.raises(SimulationError, match=words):
        weigh(bar(), bar_skin(), ElasticLayer(), model, mass=mass)


@pytest.mark.long
def test_model_without_readings_of_the_weight_is_named():
    """MuJoCo's taxels feel depth, and in a stiff cover the weight has none."""
    with pytest.raises(SimulationError, match=r"rests on the skin, but no taxel reads pressure"):
        weigh(arm().robot, arm().skin, ElasticLayer(stiffness=1e5), "depth")


def test_weight_that_sinks_through_the_cover_is_reported():
    with pytest.raises(SimulationError, match=r"does not come to rest.*mm lower.*stiffer cover"):
        weigh(bar(hinged=False), bar_skin(), ElasticLayer(stiffness=10.0), "water-fill", mass=1.0)
