"""Objects of a scene as obstacles for path planning."""

from __future__ import annotations

from collections.abc import Sequence
from typing import assert_never

from tactile_maps.control.path_following.clearance import Obstacle, ObstacleShape
from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.scene.objects import SceneObject
from tactile_maps.tactile.mechanics.loads import Box, Cylinder, Plane, Sphere


def obstacles_of(objects: Sequence[SceneObject], poses: FloatArray) -> tuple[Obstacle, ...]:
    """Return the objects at their current poses.

    Args:
        objects: Objects of the scene.
        poses: (k, 4, 4) ``T_world_object`` of each object.
    """
    return tuple(
        Obstacle(each.spec.name, _shape(each), Pose(pose[:3, :3], pose[:3, 3]))
        for each, pose in zip(objects, poses, strict=True)
    )


def _shape(scene_object: SceneObject) -> ObstacleShape:
    kind = scene_object.spec.kind
    size = scene_object.spec.size
    match kind:
        case "sphere" | "probe":
            return Sphere(size[0])
        case "box" | "plate":
            x, y, z = size
            return Box((x / 2, y / 2, z / 2))
        case "cylinder":
            return Cylinder(size[0], size[1] / 2)
        case "plane":
            return Plane()
        case "mesh":
            return scene_object.mesh
        case _:
            assert_never(kind)
