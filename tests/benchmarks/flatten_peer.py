"""Unwrapping of one disk by Blender and xatlas, in a separate Python installation and process.

    PYTHON flatten_peer.py blender-min-stretch|blender-angle|xatlas DISK.npz OUT.npz [ITERATIONS]

OUT.npz contains the UV coordinates of the faces' corners (m, 3, 2) and the duration of the call [s].
"""

from __future__ import annotations

import sys
import time

import numpy as np


def blender(vertices: np.ndarray, faces: np.ndarray, **how: object) -> tuple[np.ndarray, float]:
    """Run ``bpy.ops.uv.unwrap`` on a mesh with all faces selected."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    mesh = bpy.data.meshes.new("disk")
    mesh.from_pydata(vertices.tolist(), [], faces.tolist())
    body = bpy.data.objects.new("disk", mesh)
    bpy.context.collection.objects.link(body)
    bpy.context.view_layer.objects.active = body
    body.select_set(True)
    mesh.uv_layers.new(name="map")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    start = time.perf_counter()
    bpy.ops.uv.unwrap(margin=0.0, **how)
    seconds = time.perf_counter() - start
    bpy.ops.object.mode_set(mode="OBJECT")
    uv = np.zeros(2 * len(mesh.loops))
    mesh.uv_layers.active.data.foreach_get("uv", uv)
    return uv.reshape(-1, 3, 2), seconds


def xatlas(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, float]:
    """Run ``xatlas.parametrize``, which chooses its own cuts."""
    import xatlas as library

    start = time.perf_counter()
    _, corners, uv = library.parametrize(vertices.astype(np.float32), faces.astype(np.uint32))
    return uv[corners].astype(np.float64), time.perf_counter() - start


def main() -> None:
    """Run the command described in the module docstring."""
    peer, source, target, *rest = sys.argv[1:]
    disk = np.load(source)
    if peer == "blender-min-stretch":
        found = blender(
            disk["vertices"],
            disk["faces"],
            method="MINIMUM_STRETCH",
            iterations=int(rest[0]),
            no_flip=True,
            fill_holes=False,
        )
    elif peer == "blender-angle":
        found = blender(disk["vertices"], disk["faces"], method="ANGLE_BASED", fill_holes=False)
    else:
        found = xatlas(disk["vertices"], disk["faces"])
    np.savez(target, corners=found[0], seconds=found[1])


if __name__ == "__main__":
    main()
