"""The same path on the body for every map: drawn on the true map and transferred to the believed one.

A figure of 30 mm drawn on a map that compresses the skin is shorter on the body, so that times would depend on the size
of the drawing. Where the believed map differs, the path is therefore a polyline through the places of the true one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.paths import draw_path, path_about
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import same_triangles
from tactile_maps.studies.testbeds.path_following import PathSetup

_CORNERS = 128
"""Number of corners of the polyline: 0.7 mm apart on a path of 91 mm."""


def with_path_on_body(settings: ControlSettings, setup: PathSetup) -> ControlSettings:
    """Return the settings with their path about the contact on the true map; a polyline on another, believed map.

    Cost: 20 ms with a believed map.
    """
    if setup.believed is None:
        return settings
    true = setup.prepared.map
    centre = true.to_map(touched_place(setup.prepared))
    drawn = path_about(settings.path_kind, centre, settings.path_size)
    distances = np.linspace(0.0, drawn.length, _CORNERS, endpoint=False)
    points = np.array([drawn.at(distance)[0] for distance in (*distances, 0.0)])
    transferred = transfer_points(points, true, setup.believed)
    return replace(settings, path_kind="polyline", path=tuple((float(x), float(y)) for x, y in transferred))


def path_length(settings: ControlSettings) -> float:
    """Return the length of a round of the path of the settings, drawn or about the contact [m on the map]."""
    if settings.path:
        return draw_path(settings.path_kind, settings.path).length
    return path_about(settings.path_kind, np.zeros(2), settings.path_size).length


def touched_place(prepared: PreparedScene) -> SurfacePoint:
    """Return the place of the skin nearest to the first object when the robot is at home."""
    configuration = Configuration(prepared.robot)
    middle = np.array(prepared.scene.objects[0].at)
    found = []
    for number, patch in enumerate(prepared.skin.patches):
        at = configuration.pose(patch.link).inverse.points(middle)
        faces, weights, away = ClosestPoint(patch.surface).query(at[None])
        found.append((float(away[0]), _surface_point(number, int(faces[0]), weights[0])))
    return min(found, key=lambda one: one[0])[1]


def transfer_points(points: FloatArray, true: TactileMap, believed: TactileMap) -> FloatArray:
    """Return the points (k, 2) of the believed map [m] of the body places of ``points`` (k, 2) of the true map.

    A misplaced skin has the triangles of the true one, so that a place has the same coordinates. A learned map has its
    own triangles between taxels, and the nearest place is used. Points outside the true map are left out.
    """
    found = []
    nearest: dict[int, ClosestPoint] = {}
    for patch, face, weights in zip(*true.to_body_many(points), strict=True):
        if face < 0:
            continue
        place = _surface_point(int(patch), int(face), weights)
        other = believed.skin.patches[place.patch]
        if not same_triangles(true.skin.patches[place.patch], other):
            surface = nearest.setdefault(place.patch, ClosestPoint(other.surface))
            faces, shares, _ = surface.query(true.skin.position(place)[None])
            place = _surface_point(place.patch, int(faces[0]), shares[0])
        found.append(believed.to_map(place))
    return np.array(found).reshape(-1, 2)


def _surface_point(patch: int, face: int, weights: FloatArray) -> SurfacePoint:
    a, b, c = weights.tolist()
    return SurfacePoint(patch, face, (a, b, c))
