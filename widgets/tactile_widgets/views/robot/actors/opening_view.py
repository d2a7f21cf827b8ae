"""Initial viewpoint of a scene: a side from which the robot does not hide the points of interest.

They are known at the start: the locations that the first stimulus touches and that objects will touch, or the
controller's path.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import SceneError
from tactile_maps.geometry.surface.raycast import RayCaster, ray_caster
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.stimuli.skin_locations import SkinLocator
from tactile_maps.stimuli.stimulus import Stimulus

DEFAULT_DIRECTION = np.array([0.45, 0.95, 0.42])
"""Direction from the robot to the camera: front is +x, z is up, and the side is that of a left arm."""
_SIDES = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [-1, -1, 1]])
_OBJECT_POINTS = 24
_TRACK_POINTS = 6
_LIFT = 1e-3
_LEAST_GAIN = 0.2
"""Additional fraction of the points that another side must show to replace the usual one."""
_NEAR = 0.25
"""Distance up to which an object will touch the skin of the robot in its home posture [m]."""


@dataclass(frozen=True, eq=False)
class PlacesOfInterest:
    """Points of interest, for the robot in its home posture.

    Attributes:
        points: (k, 3) [m], world; may be empty.
        normals: (k, 3) outward unit normals of points on the skin; NaN for points of objects.
    """

    points: FloatArray
    normals: FloatArray

    def __len__(self) -> int:
        return len(self.points)

    def equals(self, other: PlacesOfInterest) -> bool:
        """Whether both have the same points and normals."""
        same = np.array_equal(self.points, other.points)
        return same and np.array_equal(self.normals, other.normals, equal_nan=True)


def places_of_interest(prepared: PreparedScene, poses: FloatArray) -> PlacesOfInterest:
    """Find the points of interest of a scene.

    Args:
        prepared: The scene.
        poses: (links, 4, 4) ``T_world_link`` in the home posture.

    Cost: 2 ms for a stimulus.
    """
    scene = prepared.scene
    positions, outward = taxels_in_world(prepared, poses)
    found = [_near_objects(prepared, positions, outward)]
    if scene.stimuli:
        first = min(scene.stimuli, key=lambda stimulus: stimulus.begin or 0.0)
        taxels = _touched(prepared, first)
        found.append((positions[taxels], outward[taxels]))
    points, normals = (np.concatenate([one[k] for one in found]) for k in (0, 1))
    if not len(points) and (path := scene.control.get("path")):
        corners = np.array(path, float).reshape(-1, 2)
        taxels = _nearest(prepared.map.taxel_points, corners)
        points = positions[taxels]
        normals = outward[taxels]
    return PlacesOfInterest(points, normals)


def _touched(prepared: PreparedScene, stimulus: Stimulus) -> IntArray:
    """Taxels along the track of a stimulus's first finger; none if its locations are not on this skin."""
    skin = prepared.skin
    try:
        tracks = stimulus.tracks(SkinLocator(skin))
    except SceneError:  # the session reports it, with its place in the scene file
        tracks = ()
    if not tracks:
        return np.zeros(0, int)
    track = tracks[0]
    numbers = []
    for k in np.unique(np.linspace(0, len(track.points) - 1, _TRACK_POINTS).astype(int)).tolist():
        patch = int(track.patches[k])
        own = skin.patches[patch].taxels.positions
        numbers.append(int(skin.first[patch]) + int(np.linalg.norm(own - track.points[k], axis=1).argmin()))
    return np.unique(numbers)


def _near_objects(prepared: PreparedScene, positions: FloatArray, normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points and normals of the objects near the skin, and of the taxel nearest to each, given those of all taxels."""
    found = [np.zeros((0, 3))]
    outward = [np.zeros((0, 3))]
    for number, body in enumerate(prepared.objects):
        if body.spec.kind == "plane":
            continue
        points = _object_points(prepared, number)
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        away = np.linalg.norm(positions - middle, axis=1)
        if len(away) and away.min() > _NEAR + 0.5 * float(np.linalg.norm(np.ptp(points, axis=0))):
            continue
        nearest = away.argsort()[:1]
        found += [points, positions[nearest]]
        outward += [np.full_like(points, np.nan), normals[nearest]]
    return np.concatenate(found), np.concatenate(outward)


def taxels_in_world(prepared: PreparedScene, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return positions [m] and unit normals, (taxels, 3) each, world frame, for link poses (links, 4, 4)."""
    positions = [np.zeros((0, 3))]
    normals = [np.zeros((0, 3))]
    for patch in prepared.skin.patches:
        pose = poses[prepared.robot.link_index[patch.link]]
        positions.append(patch.taxels.positions @ pose[:3, :3].T + pose[:3, 3])
        normals.append(patch.taxels.normals @ pose[:3, :3].T)
    return np.concatenate(positions), np.concatenate(normals)


def _nearest(places: FloatArray, points: FloatArray) -> IntArray:
    return np.unique([int(np.linalg.norm(places - point, axis=1).argmin()) for point in points])


def initial_direction(prepared: PreparedScene, poses: FloatArray, places: PlacesOfInterest) -> FloatArray:
    """(3,) direction from the robot to the camera.

    Args:
        prepared: The scene.
        poses: (links, 4, 4) ``T_world_link`` in the home posture.
        places: Points that must be visible.

    Cost: 10 ms per link; none without points.
    """
    if not len(places):
        return DEFAULT_DIRECTION
    links = [(number, link.mesh) for number, link in enumerate(prepared.robot.links) if link.mesh is not None]
    casters = [(poses[number], ray_caster(mesh)) for number, mesh in links if len(mesh.faces)]
    seen = [_share_seen(places, side, casters) for side in _SIDES * DEFAULT_DIRECTION]
    best = int(np.argmax(seen))
    return (_SIDES[best] if seen[best] > seen[0] + _LEAST_GAIN else _SIDES[0]) * DEFAULT_DIRECTION


def _share_seen(places: PlacesOfInterest, away: FloatArray, casters: list[tuple[FloatArray, RayCaster]]) -> float:
    """Fraction of the points that face a distant camera in this direction and that no link hides."""
    facing = ~(places.normals @ away <= 0)
    seen = [
        bool(faces) and not _hidden(point, away, casters) for point, faces in zip(places.points, facing, strict=True)
    ]
    return float(np.mean(seen))


def _object_points(prepared: PreparedScene, number: int) -> FloatArray:
    """(k, 3) vertices spread over an object, world [m]."""
    body = prepared.objects[number]
    corners = body.mesh.vertices[np.linspace(0, len(body.mesh.vertices) - 1, _OBJECT_POINTS).astype(int)]
    return body.spec.pose.points(corners)


def _hidden(point: FloatArray, away: FloatArray, casters: list[tuple[FloatArray, RayCaster]]) -> bool:
    """Whether the robot is between a point and a distant camera in this direction."""
    along = away / np.linalg.norm(away)
    start = point + _LIFT * along
    return any(
        caster.first_hit(pose[:3, :3].T @ (start - pose[:3, 3]), pose[:3, :3].T @ along) is not None
        for pose, caster in casters
    )
