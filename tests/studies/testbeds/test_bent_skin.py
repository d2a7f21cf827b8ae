"""A piece of skin of stated curvature: its shape by formula, and how it sits on a robot."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.maps.evaluation.quality import measure
from tactile_maps.studies.testbeds.bent_skin import BODIES, HEIGHT, REACH, bent_disc, with_bent_skin
from tactile_maps.studies.testbeds.fixed_ball import with_fixed_ball
from tactile_maps.studies.testbeds.path_following import PathSetup
from tests.support.pressed_arm import forearm

PITCH = 0.008


@pytest.mark.parametrize("body", BODIES)
def test_curvatures_in_the_middle_have_the_stated_values(body):
    disc = bent_disc(BODIES[body])
    x, y, z = disc.vertices[np.linalg.norm(disc.vertices, axis=1) < 0.01].T
    across, along, twist = np.linalg.lstsq(np.stack([-x * x / 2, -y * y / 2, x * y], axis=1), z, rcond=None)[0]
    assert (across, along) == pytest.approx(BODIES[body], abs=0.02 * 25)
    assert twist == pytest.approx(0.0, abs=1e-6)
    assert disc.face_normals[:, 2].min() > 0


def test_sphere_is_round_and_cylinder_keeps_the_lengths_of_the_plate():
    sphere = bent_disc((25.0, 25.0))
    assert np.linalg.norm(sphere.vertices + [0.0, 0.0, 0.04], axis=1) == pytest.approx(0.04, abs=1e-12)
    plate = bent_disc((0.0, 0.0))
    cylinder = bent_disc((25.0, 0.0))
    assert np.ptp(plate.vertices[:, 2]) == 0.0
    assert cylinder.area == pytest.approx(plate.area, rel=1e-3)  # chords of the arc
    assert plate.area == pytest.approx(np.pi * REACH**2, rel=0.01)


@pytest.mark.long
@pytest.mark.parametrize("body", ["plate", "saddle of 40 mm"])
def test_curved_skin_is_centred_on_a_taxel_and_is_the_only_link_touching_the_ball(body):
    placed = forearm()
    taxel = 150
    bent, middle = with_bent_skin(placed, taxel, BODIES[body], pitch=PITCH, seed=1)
    old, (patch,) = placed.skin.patches[0].taxels, bent.skin.patches
    over = old.positions[taxel] + HEIGHT * old.normals[taxel]
    assert patch.link == placed.skin.patches[0].link
    assert np.linalg.norm(patch.taxels.positions[middle] - over) < PITCH
    assert patch.surface.area / len(patch.taxels) == pytest.approx(PITCH**2, rel=0.02), "as dense as on the link"
    assert 8 < len(patch.surface.faces) / len(patch.taxels) < 14, "pressure is asked at that many points of each"
    assert measure(bent.map).bijective
    session = PathSetup(with_fixed_ball(bent, taxel=middle)).session(
        ControlSettings(controller="hybrid", task="hold_point", force_goal=3.0)
    )
    for _ in range(200):
        session.tick()
    (region,) = session.frame.regions
    assert region.force == pytest.approx(3.0, rel=0.05)
    assert session.total_normal_force == pytest.approx(3.0, rel=0.05), "nothing else holds the ball"
