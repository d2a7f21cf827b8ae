"""Scene objects for tests."""

from __future__ import annotations

from dataclasses import replace

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.scene.object_meshes import primitive_mesh
from tactile_maps.scene.objects import ObjectKind, ObjectSpec, SceneObject

SIZES: dict[ObjectKind, tuple[float, ...]] = {
    "probe": (0.01,),
    "plane": (1.0, 1.0),
    "box": (0.06, 0.05, 0.02),
    "cylinder": (0.03, 0.02),
    "sphere": (0.02,),
    "mesh": (),
    "plate": (0.06, 0.06, 0.02),
}


def thing(kind: ObjectKind, *, mesh: Mesh | None = None, **said) -> SceneObject:
    """Return an object of usual size, named after its kind; a mesh is an octagonal ball unless ``mesh`` is given."""
    size = said.pop("size", SIZES[kind])
    spec = ObjectSpec(said.pop("name", kind), kind, size, file="thing.obj" if kind == "mesh" else "", **said)
    if kind == "mesh":
        return SceneObject(spec, mesh or primitive_mesh(ObjectSpec("ball", "sphere", (0.02,))))
    return SceneObject(spec, primitive_mesh(spec))


def every_kind() -> tuple[SceneObject, ...]:
    """Return one object of each kind, far from each other and from any robot."""
    masses = {"box": 1.0, "cylinder": 1.0, "mesh": 0.5}
    return tuple(
        thing(kind, at=(5.0, float(row), 5.0 if kind != "plane" else -5.0), mass=masses.get(kind, 0.0))
        for row, kind in enumerate(SIZES)
    )


def renamed(body: SceneObject, name: str) -> SceneObject:
    """Return the object with another name."""
    return replace(body, spec=replace(body.spec, name=name))
