"""Skin under a ray: what is seen is what is picked, wherever the links are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.object_meshes import primitive_mesh
from tactile_maps.scene.objects import ObjectSpec, SceneObject
from tactile_widgets.views.robot.actors.camera import CameraRay
from tactile_widgets.views.robot.picking import SkinPicker


@pytest.fixture(scope="module")
def picker(prepared):
    return SkinPicker(prepared)


def place(prepared, poses, at):
    pose = poses[prepared.robot.link_index[prepared.skin.link(at)]]
    normal = pose[:3, :3] @ prepared.skin.normal(at)
    return pose[:3, :3] @ prepared.skin.position(at) + pose[:3, 3], normal


@pytest.mark.parametrize("seed", range(3))
def test_ray_to_a_taxel_finds_it_in_any_posture(prepared, picker, seed):
    rng = np.random.default_rng(seed)
    configuration = Configuration(prepared.robot)
    configuration.update(prepared.robot.home + rng.uniform(-0.3, 0.3, len(prepared.robot.home)))
    poses = configuration.poses()
    for taxel in range(0, len(prepared.skin), 7):
        point, normal = place(prepared, poses, prepared.skin.taxel_point(taxel))
        found = picker.pick(CameraRay(point + 2e-3 * normal, -normal), poses)
        assert found is not None
        np.testing.assert_allclose(place(prepared, poses, found)[0], point, atol=2e-4)


def test_first_surface_along_a_ray_is_picked_and_bare_links_hide_skin(prepared, picker):
    poses = Configuration(prepared.robot).poses()
    rng = np.random.default_rng(0)
    hidden = 0
    for taxel in range(len(prepared.skin)):
        point, _ = place(prepared, poses, prepared.skin.taxel_point(taxel))
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        found = picker.pick(CameraRay(point - 3.0 * direction, direction), poses)
        if found is None:
            hidden += 1
            continue
        met, normal = place(prepared, poses, found)
        assert (met - point) @ direction <= 1e-4
        assert normal @ direction < 0.2  # the side that looks at the eye
    assert 0 < hidden < len(prepared.skin) / 2


def test_rays_pass_through_hidden_bodies(prepared):
    picker = SkinPicker(prepared)
    poses = Configuration(prepared.robot).poses()
    at = prepared.skin.taxel_point(0)
    point, normal = place(prepared, poses, at)
    ray = CameraRay(point + 2e-3 * normal, -normal)
    link = prepared.robot.link_index[prepared.skin.link(at)]
    near = picker.any_body(ray, poses)[1]
    picker.hidden = frozenset({link})
    found = picker.pick(ray, poses)
    assert found is None or prepared.skin.link(found) != prepared.skin.link(at)
    assert picker.bare_body(ray, poses) != link
    behind, distance = picker.any_body(ray, poses) or (None, np.inf)
    assert behind != link
    assert distance > near


def test_ray_next_to_the_robot_finds_no_skin(prepared, picker):
    away = CameraRay(np.array([5.0, 0.0, 5.0]), np.array([1.0, 0.0, 0.0]))
    assert picker.pick(away, Configuration(prepared.robot).poses()) is None


def test_object_in_front_hides_the_skin(prepared):
    crate = ObjectSpec("crate", "box", size=(0.1, 0.1, 0.1))
    picker = SkinPicker(replace(prepared, objects=(SceneObject(crate, primitive_mesh(crate)),)))
    links = Configuration(prepared.robot).poses()
    point, normal = place(prepared, links, prepared.skin.taxel_point(70))
    ray = CameraRay(point + 0.3 * normal, -normal)
    away = np.eye(4)
    between = np.eye(4)
    away[:3, 3] = point + [0.0, 0.0, 5.0]
    between[:3, 3] = point + 0.15 * normal
    assert picker.pick(ray, np.concatenate([links, away[None]])) is not None
    assert picker.pick(ray, np.concatenate([links, between[None]])) is None
