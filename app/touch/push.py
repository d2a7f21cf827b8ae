"""What a contact model of its own did between two bodies in one step."""

from __future__ import annotations

from typing import NamedTuple

from app.arrays import FloatArray


class Push(NamedTuple):
    """Force and torque, in the world.

    Attributes:
        body: Number in the model of the body that they act on.
        other: Of the other one, on which the opposite acts.
        point: (3,) where the force acts [m].
        force: (3,) [N].
        torque: (3,) about that point [N m].
    """

    body: int
    other: int
    point: FloatArray
    force: FloatArray
    torque: FloatArray
