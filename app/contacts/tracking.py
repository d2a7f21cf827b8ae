"""Which contact region of this frame is which of the last: ids kept through motion, merging, splitting and short
absence.

``RegionTracker`` assigns ids by shared taxels; ``TrackMemory`` keeps contacts that are gone, for as long as they may
come back as who they were.

A finger that slides over a gap between taxels, or that a slow skin samples just then, lifts from the skin as little as
a foot that steps over a crack. So a contact that comes back soon enough, no farther off than a finger can have moved
meanwhile, keeps its id; and only one that is not awaited any more has been released (``events``).

How soon is soon enough depends on what was felt. A wide contact is never lost between taxels: it is awaited as long as
a reading may have failed. Where taxels have gaps between them, one of a taxel or two may have slipped into one, so it
is awaited until it has crossed it; but only beside where it was. In the same place it is another tap.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence, Set
from typing import NamedTuple

from scipy.spatial import cKDTree

from app.contacts.regions import TaxelGroup
from app.core.arrays import FloatArray
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
"""How fast a finger moves over the skin [m/s]; strokes are made at 0.01 to 0.1 m/s, and rarely above."""


class _LostTrack(NamedTuple):
    """Who it was, on which link and taxels, since when it is not there, and until when it may come back [s]."""

    id: int
    link: str
    group: TaxelGroup
    left: float
    until: float


class TrackMemory:
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
        self._gone: list[_LostTrack] = []

    @property
    def dwell(self) -> float:
        """For how long a wide contact is awaited [s]."""
        return max(DWELL, MISSED * self.period)

    def lose(self, id_: int, group: TaxelGroup, now: float) -> None:
        """The contact ``id_``, last on ``group``, is not there from the time ``now`` [s] on."""
        if self.waits:
            narrow = self.gaps and len(group.core) <= NARROW
            wait = max(self.dwell, GAP + self.period) if narrow else self.dwell
            self._gone.append(_LostTrack(id_, self._links[min(group.core)], group, now, now + wait))

    def find(self, group: TaxelGroup, now: float) -> int | None:
        """Whose contact has come back on ``group``, the nearest; None for nobody's. It is not gone any more then.

        Cost: 0.1 µs when nobody is gone, else 50 µs for each.
        """
        near = [(apart, gone) for gone in self._waiting(now) if (apart := self._apart(gone, group, now)) is not None]
        if not near:
            return None
        back = min(near, key=lambda pair: (pair[0], pair[1].id))[1]
        self._gone.remove(back)
        if now - back.left >= self.dwell and back.group.core & group.core:
            return None  # it was let go, and tapped again
        return back.id

    def may_return(self, now: float) -> Mapping[int, str]:
        """Who may still come back, and on which link. Cost: 0.1 µs when nobody is gone."""
        return {gone.id: gone.link for gone in self._waiting(now)} if self._gone else {}

    def _waiting(self, now: float) -> list[_LostTrack]:
        self._gone = [gone for gone in self._gone if now < gone.until]
        return self._gone

    def _apart(self, gone: _LostTrack, group: TaxelGroup, now: float) -> float | None:
        """From the old taxels with their ring to the nearest new one [m]; None where no finger can have come."""
        after = sorted(group.core)
        if self._links[after[0]] != gone.link:
            return None
        away, _ = cKDTree(self._body[sorted(gone.group.core | gone.group.ring)]).query(self._body[after])
        apart = float(away.min())
        return apart if apart <= SPEED * (now - gone.left + self.period) else None


class TrackId(NamedTuple):
    """Who a region is.

    Attributes:
        id: Its own.
        merged: Ids that have become part of it at this frame.
        split_from: The id it has come off at this frame; None for none.
    """

    id: int
    merged: tuple[int, ...] = ()
    split_from: int | None = None


class RegionTracker:
    """Names groups of taxels frame by frame. Mutable; ``reset`` forgets them all.

    A region is the heir of the one that it shares most touched taxels with; or, moved on by more than that, of one in
    whose ring it stands; or, farther still, of one whose ring its own ring meets; these two only if that one has no
    other heir. Where several regions have one heir they have merged: the oldest keeps its name. Where one has left
    several parts it has split: the largest part keeps the name.

    A contact that jumps by more than its own size and two rings between two frames is a new one, and so is one that
    comes back; unless the memory knows it.

    Args:
        memory: Of contacts that are gone; by default none comes back.
    """

    def __init__(self, memory: TrackMemory | None = None) -> None:
        self._memory = memory
        self.reset()

    def reset(self) -> None:
        """Forget them all; ids start at 1 again."""
        self._core: dict[int, int] = {}  # id by touched taxel
        self._ring: dict[int, int] = {}  # id by ring taxel
        self._groups: dict[int, TaxelGroup] = {}  # by id
        self._next = 1
        if self._memory is not None:
            self._memory.reset()

    def assign(self, groups: Sequence[TaxelGroup], *, now: float = 0.0) -> list[TrackId]:
        """Who each of ``groups`` is, in their order. Cost: 0.2 µs a taxel.

        Args:
            groups: Of touched taxels.
            now: The time [s]; only for those who come back.
        """
        shared = [_votes(group.core, self._core) for group in groups]
        placed = {old for vote in shared for old in vote}
        votes = [vote or self._moved(group, placed) for vote, group in zip(shared, groups, strict=True)]
        heir: dict[int, tuple[int, int]] = {}  # by old id: most votes, the group
        for number, vote in enumerate(votes):
            for old, count in vote.items():
                if old not in heir or count > heir[old][0]:
                    heir[old] = count, number
        claims: list[list[int]] = [[] for _ in groups]
        for old in sorted(heir):
            claims[heir[old][1]].append(old)
        self._lose(heir.keys(), now)
        names = [
            self._identify(claim, vote, group, now) for claim, vote, group in zip(claims, shared, groups, strict=True)
        ]
        self._remember(groups, names)
        return names

    def _moved(self, group: TaxelGroup, placed: set[int]) -> Counter[int]:
        """Votes for a group that shares no touched taxel with anyone: for those who are not ``placed`` elsewhere."""
        if placed.issuperset(self._core.values()):
            return Counter()
        near = _votes(group.core, self._ring)
        far = near or _votes(group.ring, self._core) or _votes(group.ring, self._ring)
        return Counter({old: count for old, count in far.items() if old not in placed})

    def _lose(self, kept: Set[int], now: float) -> None:
        """Those who have no heir are gone; who merged has one."""
        if self._memory is not None:
            for old, group in self._groups.items():
                if old not in kept:
                    self._memory.lose(old, group, now)

    def _identify(self, claim: list[int], vote: Counter[int], group: TaxelGroup, now: float) -> TrackId:
        if claim:
            return TrackId(claim[0], tuple(claim[1:]))
        parent = min(vote, key=lambda old: (-vote[old], old), default=None)
        back = self._memory.find(group, now) if self._memory is not None and parent is None else None
        if back is not None:
            return TrackId(back)
        self._next += 1
        return TrackId(self._next - 1, (), parent)

    def _remember(self, groups: Sequence[TaxelGroup], names: Sequence[TrackId]) -> None:
        self._core, self._ring = {}, {}
        self._groups = {name.id: group for group, name in zip(groups, names, strict=True)}
        for group, name in zip(groups, names, strict=True):
            self._core.update(dict.fromkeys(group.core, name.id))
            self._ring.update(dict.fromkeys(group.ring, name.id))


def _votes(taxels: frozenset[int], owner: dict[int, int]) -> Counter[int]:
    """How many of ``taxels`` each id owns."""
    return Counter([owner[taxel] for taxel in taxels if taxel in owner])
