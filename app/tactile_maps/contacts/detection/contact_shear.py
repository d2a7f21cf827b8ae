"""Shear of one contact: force and torque along the skin, how much of its friction it uses, and whether it slips."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Slip(Enum):
    """State of the friction of a contact."""

    STICKING = "sticking"
    INCIPIENT = "incipient"
    SLIDING = "sliding"


@dataclass(frozen=True)
class ContactShear:
    """Shear of one contact.

    Attributes:
        force: Force of the touching body along the skin, frame of the link [N].
        torque: Its torque about the outward normal at the centre of the contact [N m].
        usage: Length of the force over friction times normal force; 1 while sliding.
        stuck: Share of the friction limit on taxels that stick, 0 to 1.
        slip: Whether it sticks, begins to slip at its border, or slides.
        friction: Coefficient that ``usage`` assumes.
        estimated: Whether the coefficient was measured while sliding; otherwise it is the given one.
        force_error: Standard uncertainty of each component of the force [N].
        torque_error: Standard uncertainty of the torque [N m].
        usage_error: Standard uncertainty of the usage.
    """

    force: tuple[float, float, float]
    torque: float
    usage: float
    stuck: float
    slip: Slip
    friction: float
    estimated: bool
    force_error: float = 0.0
    torque_error: float = 0.0
    usage_error: float = 0.0
