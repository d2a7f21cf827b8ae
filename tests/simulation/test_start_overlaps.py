"""An object that starts inside the robot is reported with its depth and the link."""

import pytest

from tactile_maps.scene.effects import Effects
from tactile_maps.scene.object_meshes import primitive_mesh
from tactile_maps.scene.objects import ObjectSpec, SceneObject
from tactile_maps.simulation.start_overlaps import OVERLAP, with_overlaps
from tactile_maps.studies.testbeds.contact_bench import bench

EFFECTS = Effects(contact="environment")


def ball(height, *, name="ball", radius=0.01):
    """Return a ball whose lowest point is at ``height`` [m] over the flat skin of the block."""
    spec = ObjectSpec(name, "sphere", size=(radius,), at=(0.0, 0.0, radius + height), mass=0.1)
    return SceneObject(spec, primitive_mesh(spec))


def overlaps(*objects, effects=EFFECTS):
    flat = bench("flat")
    found = with_overlaps(flat.robot, flat.taxels, effects, objects)
    return {thing.spec.name: finding.action for thing in found for finding in thing.findings if finding.kind == OVERLAP}


def test_object_inside_a_link_is_reported_with_depth_and_link():
    found = overlaps(ball(-0.004), ball(0.05, name="above"))
    assert found.keys() == {"ball"}
    assert found["ball"].startswith("starts 4 mm deep in block")


@pytest.mark.parametrize("skin", ["foundation", "depth", "off"])
def test_overlap_does_not_depend_on_the_contact_model(skin):
    assert overlaps(ball(-0.004), effects=Effects(contact="environment", skin=skin)).keys() == {"ball"}


@pytest.mark.parametrize("height", [0.001, 0.0, -0.0005])
def test_object_that_touches_at_the_start_is_not_reported(height):
    assert overlaps(ball(height)) == {}


def test_object_that_is_not_simulated_is_not_reported():
    assert overlaps(ball(-0.004), effects=Effects(contact="off")) == {}
    assert overlaps() == {}


def test_overlapping_objects_are_not_reported_as_inside_the_robot():
    assert overlaps(ball(0.03), ball(0.032, name="other")) == {}
