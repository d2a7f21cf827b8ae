"""Names of elements that are added to a robot's model: hulls or pieces of links with skin, and objects.

They have a reserved prefix, which no robot may use, followed by the kind. The prefix therefore identifies the kind, and
the parts of a robot may have any other name.
"""

from __future__ import annotations

from tactile_maps.robots.model.mujoco_spec import OWN_NAMES
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.skin.link_hulls import HULL
from tactile_maps.skin.link_pieces import piece_link, piece_number

_OBJECT, _SHAPE = (f"{OWN_NAMES}{kind} " for kind in ("object", "shape"))


def body_name(object_spec: ObjectSpec) -> str:
    """Return the name of an object's body, geom, mesh and joint."""
    return _OBJECT + object_spec.name


def shape_name(number: int) -> str:
    """Return the name of a robot's shape that has no name in its file."""
    return f"{_SHAPE}{number}"


def is_hull(name: str) -> bool:
    """Whether a geom or mesh of that name is the hull of a skinned link, or a piece of it."""
    return name.startswith(HULL) or piece_number(name) is not None


def is_object(name: str) -> bool:
    """Whether a geom or mesh of that name belongs to an object."""
    return name.startswith(_OBJECT)


def plain_name(name: str) -> str:
    """Return the name in the file of the robot or scene, for display."""
    name = piece_link(name)
    for kind in (HULL, _OBJECT, _SHAPE):
        name = name.removeprefix(kind)
    return name
