"""Contacts that are gone, for as long as they may come back as who they were.

A finger that slides over a gap between taxels, or that a slow skin samples just then, lifts from the skin as little as
a foot that steps over a crack. So a contact that comes back soon enough, and no farther off than a hand can have moved
meanwhile, keeps its name; and only one that is not awaited any more has been released (``events``).

How soon is soon enough depends on what was felt. A wide contact is never lost between taxels: it is awaited as long as
a reading may have failed. Where taxels have gaps between them, one of a taxel or two may have slipped into one, so it
is awaited until it has crossed it; but only beside where it was. In the same place it is another tap.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from scipy.spatial import cKDTree

from app.arrays import FloatArray
from app.contacts.graph import Group
from app.skin.skin import Skin

DWELL = 0.05
"""For how long any contact is awaited [s]: less than the 70 ms for which a finger is off the skin that taps as fast as
it can, 7 times a second."""
MISSED = 1.5
"""The same in samples of a slow skin: missing in one is no release, missing in two is."""
GAP = 0.3
"""For how long a narrow contact is awaited [s]: a stroke of 5 cm/s crosses a gap of 15 mm."""
NARROW = 2
"""Taxels that such a contact touches at most."""
SPEED = 0.2
"""How fast a hand moves on over the skin [m/s]; strokes are made at 0.01 to 0.1 m/s, and rarely above."""


class _Gone(NamedTuple):
    """Who it was, on which link and taxels, since when it is not there, and until when it may come back [s]."""

    id: int
    link: str
    group: Group
    left: float
    until: float


class Lost:
    """Remembers who is gone. Mutable; ``reset`` forgets them.

    Args:
        skin: The skin.
        body: (taxels, 3) positions on it [m], each in its link's frame.

    Attributes:
        waits: Whether anybody is awaited at all.
        gaps: Whether there is skin between the taxels that feels nothing.
        period: Of the skin's own samples [s]: what is read may be so much older than it is; 0 for none.
    """

    def __init__(self, skin: Skin, body: FloatArray) -> None:
        self._body = body
        self._links = [skin.patches[patch].link for patch in skin.patch_of.tolist()]
        self.waits, self.gaps, self.period = False, False, 0.0
        self.reset()

    def reset(self) -> None:
        """Nobody is gone."""
        self._gone: list[_Gone] = []

    @property
    def dwell(self) -> float:
        """For how long a wide contact is awaited [s]."""
        return max(DWELL, MISSED * self.period)

    def lose(self, id_: int, group: Group, now: float) -> None:
        """The contact ``id_``, last on ``group``, is not there from the time ``now`` [s] on."""
        if self.waits:
            narrow = self.gaps and len(group.core) <= NARROW
            wait = max(self.dwell, GAP + self.period) if narrow else self.dwell
            self._gone.append(_Gone(id_, self._links[min(group.core)], group, now, now + wait))

    def find(self, group: Group, now: float) -> int:
        """Whose contact has come back on ``group``, the nearest; 0 for nobody's. It is not gone any more then.

        Cost: 0.1 µs when nobody is gone, else 50 µs for each.
        """
        near = [(apart, gone) for gone in self._waiting(now) if (apart := self._apart(gone, group, now)) is not None]
        if not near:
            return 0
        back = min(near, key=lambda pair: (pair[0], pair[1].id))[1]
        self._gone.remove(back)
        if now - back.left >= self.dwell and back.group.core & group.core:
            return 0  # it was let go, and tapped again
        return back.id

    def may_return(self, now: float) -> Mapping[int, str]:
        """Who may still come back, and on which link. Cost: 0.1 µs when nobody is gone."""
        return {gone.id: gone.link for gone in self._waiting(now)} if self._gone else {}

    def _waiting(self, now: float) -> list[_Gone]:
        self._gone = [gone for gone in self._gone if now < gone.until]
        return self._gone

    def _apart(self, gone: _Gone, group: Group, now: float) -> float | None:
        """From the old taxels with their ring to the nearest new one [m]; None where a hand cannot have come."""
        after = sorted(group.core)
        if self._links[after[0]] != gone.link:
            return None
        away, _ = cKDTree(self._body[sorted(gone.group.core | gone.group.ring)]).query(self._body[after])
        apart = float(away.min())
        return apart if apart <= SPEED * (now - gone.left + self.period) else None
