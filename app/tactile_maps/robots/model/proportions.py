"""Numbers of a robot that are probably in another unit: meshes in millimetres, and ranges of joints in degrees."""

from __future__ import annotations

import mujoco
import numpy as np

from tactile_maps.core.errors import Finding, places_finding
from tactile_maps.robots.files.mesh_files import LARGEST_IN_METRES

OVERSIZED = "mesh-size"
"""Kind of the finding about such a mesh."""
IN_DEGREES = "joint-range"
"""Kind of the finding about ranges that are probably in degrees."""
_LARGEST_ANGLE = 4 * np.pi
_MOST_DEGREES = 720.0
_LARGEST_SIZE = 2 * LARGEST_IN_METRES  # m, of the bounding box's diagonal
_LARGEST_RATIO = 20.0
_LEAST_SIZE = 2.0  # m; smaller meshes are possible on a robot whose joints are all at one place


def oversized_meshes(model: mujoco.MjModel) -> list[Finding]:
    """Return a finding for each mesh larger than 20 m, or than 2 m and 20 times the robot.

    The size of the robot is the longest chain of its links or the largest radius of gyration of a link, whichever is
    larger. Inertia that MuJoCo computes from an oversized mesh is as large as the mesh; the first limit then applies.
    """
    meshes = np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_MESH)
    sizes = 2 * np.linalg.norm(model.geom_aabb[meshes, 3:], axis=1)
    robot = _size_of_robot(model)
    limit = min(max(_LARGEST_RATIO * robot, _LEAST_SIZE), _LARGEST_SIZE) if model.njnt else _LARGEST_SIZE
    findings = list[Finding]()
    links: dict[int, tuple[float, dict[str, None]]] = {}
    for geom, size in zip(meshes, sizes, strict=True):
        if size > limit:
            _, named = links.setdefault(int(model.geom_dataid[geom]), (float(size), {}))
            named[model.body(int(model.geom_bodyid[geom])).name] = None
    for mesh, (size, named) in links.items():
        compared = f"; the joints of the robot span {robot:.2g} m" if model.njnt else ""
        action = (
            f"its mesh {model.mesh(mesh).name} is {size:.3g} m across{compared}. If the mesh is in millimetres, "
            'state scale="0.001 0.001 0.001" for it in the robot\'s file'
        )
        findings += places_finding(OVERSIZED, list(named), action)
    return findings


def ranges_in_degrees(model: mujoco.MjModel) -> list[Finding]:
    """Return a finding for hinges whose range exceeds two turns in radians and is a whole number of degrees."""
    ranges = model.jnt_range
    largest = np.abs(ranges).max(axis=1, initial=0.0)
    whole = (ranges == np.round(ranges)).all(axis=1)
    hinges = (model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE) & (model.jnt_limited != 0)
    found = np.flatnonzero(hinges & whole & (largest > _LARGEST_ANGLE) & (largest <= _MOST_DEGREES))
    places = [f"{model.joint(int(joint)).name} ({ranges[joint][0]:g} to {ranges[joint][1]:g} rad)" for joint in found]
    return places_finding(IN_DEGREES, places, "ranges of several turns. If they are in degrees, state them in radians")


def _size_of_robot(model: mujoco.MjModel) -> float:
    """Return the length of the longest chain of links or the largest radius of gyration [m]."""
    reach = np.zeros(model.nbody)
    for body in range(1, model.nbody):
        parent = int(model.body_parentid[body])
        if parent:  # the place of the base is no measure
            reach[body] = reach[parent] + float(np.linalg.norm(model.body_pos[body]))
    massive = (model.body_weldid != 0) & (model.body_mass > 0)
    gyration = np.sqrt(model.body_inertia[massive].max(axis=1, initial=0.0) / model.body_mass[massive])
    return max(float(reach.max()), float(gyration.max(initial=0.0)))
