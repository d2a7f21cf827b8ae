"""Control of several contacts: selection of those with a force goal, and detection of those the joints cannot relieve.

``ContactSelection`` adds all contacts above the force goal to the one that a task is about. Every control scheme uses
one row per contact. ``ReliefMonitor`` reports contacts that stay above their goal because the joint velocity does not
relieve them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.joint_impedance import MAX_POINT_SPEED
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.core.arrays import FloatArray

KEPT_SHARE = 0.5
"""Share of the goal down to which a contact that was above it stays controlled, so that its integral is kept."""
EXCESS_SHARE = 0.1
MIN_EXCESS = 0.2
"""Force above the goal that is not reported, as share of the goal and at least [N]."""
RELIEF_SHARE = 0.5
"""Share of the speed proportional to the excess force, below which a contact counts as not relieved."""
PATIENCE = 0.3
"""Time for which a contact is not relieved until it is reported [s]."""


class ContactSelection:
    """Selects contacts that have a force goal in addition to a first one. Mutable; ``reset`` discards them.

    A contact is selected when its force is above the goal, and stays selected down to ``KEPT_SHARE`` of it. The other
    side of a self-contact that is selected is left out: it is the same force.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Select no contacts."""
        self._ids: set[int] = set()

    def others(self, first: ContactRegion, regions: Sequence[ContactRegion], goal: float) -> list[ContactRegion]:
        """Return the selected contacts besides ``first``, in the order of ``regions``.

        Args:
            first: Contact that the controller is about.
            regions: All contacts, the strongest first.
            goal: Force goal [N].
        """
        selected = {first.id}
        found = []
        for region in regions:
            least = KEPT_SHARE * goal if region.id in self._ids else goal
            if region.id not in selected and region.partner not in selected and region.force > least:
                selected.add(region.id)
                found.append(region)
        self._ids = selected
        return found


class ControlledContact(NamedTuple):
    """A contact with a force goal.

    Attributes:
        region: The contact.
        goal: Force goal [N].
        outward: (n,) outward speed of the contact point per joint velocity.
        left_out: Whether the joint velocity was computed without it, since it was reported before.
    """

    region: ContactRegion
    goal: float
    outward: FloatArray
    left_out: bool = False


class ReliefMonitor:
    """Reports contacts above their force goal that the requested joint velocity does not relieve. Mutable.

    Controllers leave out a reported contact as long as another one can be kept at its goal; if not, the force of both
    would rise. It is reported until its force is near the goal.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all contacts."""
        self._waited: dict[int, float] = {}
        self._reasons: dict[int, LimitKind] = {}

    @property
    def unrelieved(self) -> frozenset[int]:
        """Ids of the contacts reported at the last tick."""
        return frozenset(self._reasons)

    def look(
        self,
        contacts: Iterable[ControlledContact],
        speed: FloatArray,
        max_speed: FloatArray,
        gain: float,
        dt: float,
        limits: ActiveLimits,
    ) -> None:
        """Compare the requested joint velocity with what relieves each contact.

        Args:
            contacts: All contacts that have a force goal.
            speed: (n,) requested joint velocity.
            max_speed: (n,) greatest speed of each joint.
            gain: Force gain [m/s/N].
            dt: Time since the last tick [s].
            limits: Collects ``CONTACTS_OPPOSED`` and ``CONTACT_IMMOBILE``.
        """
        contacts = sorted(contacts, key=lambda one: -one.region.force)
        waited = dict[int, float]()
        reasons = dict[int, LimitKind]()
        for region, goal, outward, left_out in contacts:
            excess = region.force - goal
            if excess <= max(EXCESS_SHARE * goal, MIN_EXCESS):
                continue
            least = RELIEF_SHARE * min(gain * excess, MAX_POINT_SPEED)
            if left_out and region.id in self._reasons:
                reasons[region.id] = self._reasons[region.id]
            elif -float(outward.dot(speed)) < least:
                waited[region.id] = self._waited.get(region.id, 0.0) + dt
                if waited[region.id] > PATIENCE and float(abs(outward).dot(max_speed)) < least:
                    reasons[region.id] = LimitKind.CONTACT_IMMOBILE
                elif waited[region.id] > PATIENCE and len(contacts) > 1:
                    reasons[region.id] = LimitKind.CONTACTS_OPPOSED
            if region.id in reasons:
                limits.add(Limit(reasons[region.id], (region.link,), value=region.force, bound=goal))
        self._waited = waited
        self._reasons = reasons
