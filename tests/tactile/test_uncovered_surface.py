"""Force on the uncovered surface of links with skin: no model reads it, every model reports it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS
from tests.support.hollows import BASE, HEIGHTS, hollow, raised
from tests.support.scene_objects import thing
from tests.support.touch import hold

MODELS = (*CONTACT_MODELS, "foundation", "depth")
MASS = 0.1
RADIUS = 0.015
GRAVITY = 9.81
LAYER = ElasticLayer(2e4)


@cache
def block(surface: str) -> tuple[Robot, Skin]:
    """Return a block whose top has skin at positive x only.

    Args:
        surface: ``flat``, ``bowl``, ``raised`` by 3 mm, ``slightly raised`` by 0.8 mm, or ``open``: raised by 3 mm
            above a mesh without bottom.
    """
    if surface in ("raised", "slightly raised", "open"):
        robot, skin = raised(0.8e-3 if surface == "slightly raised" else 3e-3)
        if surface == "open":
            mesh = robot.links[0].mesh
            faces = mesh.faces[mesh.vertices[mesh.faces].max(axis=1)[:, 2] > BASE + 1e-6]
            robot = replace(robot, links=(replace(robot.links[0], mesh=Mesh(mesh.vertices, faces)),))
        return robot, skin
    robot, skin = hollow(surface)
    top = skin.patches[0].surface
    used, corner = np.unique(top.faces[top.vertices[top.faces].mean(axis=1)[:, 0] > 0], return_inverse=True)
    half = Mesh(top.vertices[used], corner.reshape(-1, 3))
    return robot, Skin((Patch("half", "block", half, place_evenly(half, 100, seed=0)),))


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("surface", ["flat", "bowl", "raised", "slightly raised", "open"])
@pytest.mark.parametrize("model", MODELS)
def test_force_on_uncovered_surface_is_reported_and_not_read(model: str, surface: str) -> None:
    robot, skin = block(surface)
    x = -0.03
    height = float(HEIGHTS[surface](np.array(x), np.array(0.0))) if surface in HEIGHTS else 0.0
    ball = thing("sphere", size=(RADIUS,), at=(x, 0.0, height + RADIUS + 1e-3), mass=MASS, guided=True)
    effects = Effects(contact="environment", gravity="on", skin=model, fingers=False)
    simulation = Simulation(robot, skin, effects, objects=(ball,), layer=LAYER)
    simulation.step(1000, hold(robot, 0.0, 0.0))
    felt = simulation.sense()
    assert simulation.object_poses[0][2, 3] == pytest.approx(height + RADIUS, abs=3e-3), "it bears the ball"
    assert not felt.any()
    assert ContactNoteKind.OUTSIDE_SKIN in {note.kind for note in simulation.notes}
    assert simulation.wrenches()["block"][2] == pytest.approx(-MASS * GRAVITY, rel=5e-3)
