"""Keeps the one contact that is being taken to another place of the skin, from the question to its end."""

from __future__ import annotations

from collections.abc import Sequence

from app.arrays import FloatArray
from app.contacts.region import ContactRegion
from app.control.aim import Spot
from app.control.carry_plan import CarryPlan
from app.control.laid_path import Crossing
from app.control.transfer import Transfer
from app.geometry.surface_point import SurfacePoint
from app.robots.configuration import Configuration
from app.robots.robot import Robot
from app.skin.skin import Skin


class Carrier:
    """At most one transfer. Mutable; ``reset`` lets go of it.

    Args:
        robot: Whose arm; without one, or without joints, nothing can be carried.

    Attributes:
        crossing: Over which it goes; None while there is none.
        reason: Why the last one failed, in words.
    """

    def __init__(self, robot: Robot | None) -> None:
        self._robot = robot if robot is not None and robot.joints else None
        self._trial = None if self._robot is None else Configuration(self._robot)
        self.reset()

    def reset(self) -> None:
        """Nothing is carried."""
        self.crossing: Crossing | None = None
        self._asked: tuple[Skin, float, ContactRegion, frozenset[int]] | None = None
        self._transfer: Transfer | None = None

    @property
    def state(self) -> str:
        """See ``Transfer.state``; empty while nothing is carried."""
        return "" if self.crossing is None else "look" if self._transfer is None else self._transfer.state

    @property
    def moves(self) -> bool:
        """Whether the arm is on the way, without a task for any contact."""
        return self._transfer is not None and self._transfer.moves

    @property
    def says(self) -> str:
        """What goes on, in words; at the end why it failed."""
        return "" if self._transfer is None else self._transfer.says

    @property
    def reason(self) -> str:
        """Why it failed, or turned back; empty while all is well."""
        return "" if self._transfer is None else self._transfer.reason

    def ask(
        self, crossing: Crossing, region: ContactRegion, regions: Sequence[ContactRegion], skin: Skin, pitch: float
    ) -> bool:
        """Begin; false where there is no arm that could.

        Args:
            crossing: From where to where.
            region: The contact.
            regions: All there are.
            skin: Of the arm.
            pitch: Of its taxels [m].
        """
        if self._robot is None:
            return False
        self.crossing, self._transfer = crossing, None
        self._asked = skin, pitch, region, frozenset(one.id for one in regions)
        return True

    def watch(self, regions: Sequence[ContactRegion], dt: float) -> ContactRegion | None:
        """Go on by what is felt; the contact as soon as it has arrived, there or back."""
        return None if self._transfer is None else self._transfer.watch(regions, dt)

    def speed(self, start: FloatArray, rest: FloatArray, configuration: Configuration, dt: float) -> FloatArray | None:
        """(n,) joint velocity of an arm on the way; None while it is not.

        Args:
            start: (n,) the wanted posture.
            rest: (n,) the posture at rest.
            configuration: At the present posture.
            dt: To the next tick [s].
        """
        if self._asked is not None:
            self._transfer, self._asked = self._begin(start, rest, *self._asked), None
        return self._transfer.speed(start, configuration, dt) if self._transfer is not None and self.moves else None

    def _begin(
        self,
        start: FloatArray,
        rest: FloatArray,
        skin: Skin,
        pitch: float,
        region: ContactRegion,
        known: frozenset[int],
    ) -> Transfer:
        assert self._robot is not None
        assert self._trial is not None
        assert self.crossing is not None
        touched = Spot(region.link, region.point, region.normal)
        wanted = _spot(skin, self.crossing.enters)
        plan = CarryPlan(self._robot, self._trial, start, rest, touched, wanted)
        return Transfer(plan, skin, region.at, self.crossing.enters, pitch, known)


def _spot(skin: Skin, at: SurfacePoint) -> Spot:
    return Spot(skin.link(at), skin.position(at), skin.normal(at))
