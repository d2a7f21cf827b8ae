"""Contacts as whole-body controllers use them: outline, wrench and covariance of each contact and of each link.

All values are in the frame of the link. A wrench is (force [N], torque [N m]) of the touching body on the link; that of
a contact is about its position, that of a link about the link's origin. Measured is the normal force, and the shear if
the skin measures three axes. For what is not measured, the covariance assumes friction up to 1:

- force along the skin: standard deviation of the normal force in each direction,
- torque about the normal: the same times 2/3 of the radius of a disc of the contact's area (a sliding disc),
- torque along the skin: force times the uncertainty of the centre.

Without calibrated readings forces are unknown: wrenches and covariances are NaN.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.session.frame import Frame
from tactile_maps.skin.model.skin import Skin

CONTACTS_TYPE = "tactile_maps_msgs/msg/SkinContacts"
MESSAGE_TEXTS = {
    "tactile_maps_msgs/msg/SkinContact": """
# One contact, in the frame of its link.
uint32 id                      # kept while the contact lives
string link
geometry_msgs/Polygon region   # outline of the touched taxels, counter-clockwise from outside [m]
geometry_msgs/Point position   # centre of pressure [m]
geometry_msgs/Vector3 normal   # outward unit normal there
float64 area                   # of the touched taxels [m^2]
float64 peak                   # highest pressure [Pa]
geometry_msgs/Wrench wrench    # on the link, about position [N, N m]; NaN if not calibrated
float64[36] covariance         # of force x, y, z and torque x, y, z, by rows
""",
    "tactile_maps_msgs/msg/LinkWrench": """
# Sum of the contacts of a link, in its frame.
string link
geometry_msgs/Wrench wrench    # on the link, about its origin [N, N m]
float64[36] covariance         # of force x, y, z and torque x, y, z, by rows
""",
    CONTACTS_TYPE: """
# All contacts of a skin at one time.
std_msgs/Header header         # stamp of the readings
tactile_maps_msgs/SkinContact[] contacts
tactile_maps_msgs/LinkWrench[] links   # those with contacts
""",
}
"""Text of the ``.msg`` file of each type of our own."""
CONTACTS_SCHEMA = {
    "title": CONTACTS_TYPE,
    "type": "object",
    "properties": {
        "header": {"type": "object", "properties": {"stamp": {"type": "object"}, "frame_id": {"type": "string"}}},
        "contacts": {"type": "array", "items": {"type": "object"}},
        "links": {"type": "array", "items": {"type": "object"}},
    },
}
"""JSON schema of ``contacts_json``."""
_CORNERS = 8
"""Number of corners of the outline of a contact with fewer than three touched taxels."""


@dataclass(frozen=True, eq=False)
class UncertainWrench:
    """Wrench with its uncertainty.

    Attributes:
        wrench: (6,) force [N] and torque [N m].
        covariance: (6, 6) of both.
    """

    wrench: FloatArray
    covariance: FloatArray


def contact_wrench(region: ContactRegion) -> UncertainWrench:
    """Return the wrench of a contact on its link about the contact's position, in the frame of the link."""
    normal = region.link_normal
    inward = np.outer(normal, normal)
    along = np.eye(3) - inward
    force = region.force_vector
    torque = np.zeros(3)
    arm = 2 / 3 * math.sqrt(region.area / math.pi)
    tangential = region.force**2
    twist = (region.force * arm) ** 2
    if (shear := region.shear) is not None:
        torque = shear.torque * normal
        tangential = shear.force_error**2
        twist = shear.torque_error**2
    covariance = np.zeros((6, 6))
    covariance[:3, :3] = region.force_error**2 * inward + tangential * along
    tilt = (region.force * region.place_error) ** 2 / 2  # the uncertainty of the place is radial, over two directions
    covariance[3:, 3:] = twist * inward + tilt * along
    return UncertainWrench(np.concatenate([force, torque]), covariance)


def link_wrench(regions: list[ContactRegion]) -> UncertainWrench:
    """Return the sum of the wrenches of contacts on one link, about its origin; their errors are independent."""
    total = np.zeros(6)
    covariance = np.zeros((6, 6))
    for region in regions:
        one = contact_wrench(region)
        x, y, z = region.link_position
        shift = np.eye(6)
        shift[3:, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
        total += shift @ one.wrench
        covariance += shift @ one.covariance @ shift.T
    return UncertainWrench(total, covariance)


def outline(region: ContactRegion, frame: Frame, skin: Skin) -> FloatArray:
    """Return (c, 3) corners of the outline of a contact [m], frame of the link, counter-clockwise from outside.

    It is the convex hull of the touched taxels in the tangent plane; a regular octagon of the contact's area where they
    have no extent.
    """
    first = np.cross(region.link_normal, np.eye(3)[np.argmin(np.abs(region.link_normal))])
    first /= np.linalg.norm(first)
    second = np.cross(region.link_normal, first)
    count = len(region.taxels) if region.touched is None else region.touched
    touched = region.taxels[np.argsort(-frame.pressures[region.taxels], kind="stable")[:count]]
    positions = skin.positions[touched]
    flat = (positions - region.link_position) @ np.column_stack([first, second])
    if len(flat) >= 3:
        try:
            return np.asarray(positions[ConvexHull(flat).vertices])
        except QhullError:
            pass
    angles = 2 * np.pi * np.arange(_CORNERS) / _CORNERS
    radius = math.sqrt(region.area / (_CORNERS / 2 * math.sin(2 * np.pi / _CORNERS)))
    circle = np.outer(np.cos(angles), first) + np.outer(np.sin(angles), second)
    return np.asarray(region.link_position + radius * circle)


def contacts_json(frame: Frame, skin: Skin, time: int) -> dict[str, Any]:
    """Return the message ``CONTACTS_TYPE`` of a frame as JSON with the same fields; NaN is None.

    Args:
        frame: The frame.
        skin: Its skin.
        time: Time of the readings [ns since 1970].
    """
    seconds, nanoseconds = divmod(time, 10**9)
    links = dict.fromkeys(region.link for region in frame.regions)
    known = frame.units.force is not None
    return {
        "header": {"stamp": {"sec": seconds, "nanosec": nanoseconds}, "frame_id": ""},
        "contacts": [
            {
                "id": region.id,
                "link": region.link,
                "region": {"points": [_xyz(corner) for corner in outline(region, frame, skin)]},
                "position": _xyz(region.link_position),
                "normal": _xyz(region.link_normal),
                "area": region.area,
                "peak": region.peak,
                **_wrench_json(contact_wrench(region), known=known),
            }
            for region in frame.regions
        ],
        "links": [
            {"link": link, **_wrench_json(link_wrench([one for one in frame.regions if one.link == link]), known=known)}
            for link in links
        ],
    }


def _wrench_json(found: UncertainWrench, *, known: bool) -> dict[str, Any]:
    force, torque = (_xyz(part if known else 3 * [None]) for part in (found.wrench[:3], found.wrench[3:]))
    covariance = found.covariance.ravel().tolist() if known else 36 * [None]
    finite = [value if value is not None and math.isfinite(value) else None for value in covariance]
    return {"wrench": {"force": force, "torque": torque}, "covariance": finite}


def _xyz(vector: Iterable[float | None]) -> dict[str, float | None]:
    return {axis: None if value is None else float(value) for axis, value in zip("xyz", vector, strict=True)}
