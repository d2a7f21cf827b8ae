"""Which contact region of this frame is which of the last: names kept through motion, merging and splitting."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence, Set
from typing import NamedTuple

from app.contacts.graph import Group
from app.contacts.lost import Lost


class Name(NamedTuple):
    """Who a region is.

    Attributes:
        id: Its own.
        merged: Ids that have become part of it at this frame.
        split_from: The id it has come off at this frame; 0 for none.
    """

    id: int
    merged: tuple[int, ...] = ()
    split_from: int = 0


class Follower:
    """Names groups of taxels frame by frame. Mutable; ``reset`` forgets them all.

    A region is the heir of the one that it shares most touched taxels with; or, moved on by more than that, of one in
    whose ring it stands; or, farther still, of one whose ring its own ring meets; these two only if that one has no
    other heir. Where several regions have one heir they have merged: the oldest keeps its name. Where one has left
    several parts it has split: the largest part keeps the name.

    A contact that jumps by more than its own size and two rings between two frames is a new one, and so is one that
    comes back; unless ``lost`` knows it.

    Args:
        lost: Where contacts are that are gone; by default none comes back.
    """

    def __init__(self, lost: Lost | None = None) -> None:
        self._lost = lost
        self.reset()

    def reset(self) -> None:
        """Forget them all; ids start at 1 again."""
        self._core: dict[int, int] = {}  # id by touched taxel
        self._ring: dict[int, int] = {}  # id by ring taxel
        self._groups: dict[int, Group] = {}  # by id
        self._next = 1
        if self._lost is not None:
            self._lost.reset()

    def name(self, groups: Sequence[Group], *, now: float = 0.0) -> list[Name]:
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
            self._christen(claim, vote, group, now) for claim, vote, group in zip(claims, shared, groups, strict=True)
        ]
        self._remember(groups, names)
        return names

    def _moved(self, group: Group, placed: set[int]) -> Counter[int]:
        """Votes for a group that shares no touched taxel with anyone: for those who are not ``placed`` elsewhere."""
        if placed.issuperset(self._core.values()):
            return Counter()
        near = _votes(group.core, self._ring)
        far = near or _votes(group.ring, self._core) or _votes(group.ring, self._ring)
        return Counter({old: count for old, count in far.items() if old not in placed})

    def _lose(self, kept: Set[int], now: float) -> None:
        """Those who have no heir are gone; who merged has one."""
        if self._lost is not None:
            for old, group in self._groups.items():
                if old not in kept:
                    self._lost.lose(old, group, now)

    def _christen(self, claim: list[int], vote: Counter[int], group: Group, now: float) -> Name:
        if claim:
            return Name(claim[0], tuple(claim[1:]))
        parent = min(vote, key=lambda old: (-vote[old], old), default=0)
        back = self._lost.find(group, now) if self._lost is not None and not parent else 0
        if back:
            return Name(back)
        self._next += 1
        return Name(self._next - 1, (), parent)

    def _remember(self, groups: Sequence[Group], names: Sequence[Name]) -> None:
        self._core, self._ring = {}, {}
        self._groups = {name.id: group for group, name in zip(groups, names, strict=True)}
        for group, name in zip(groups, names, strict=True):
            self._core.update(dict.fromkeys(group.core, name.id))
            self._ring.update(dict.fromkeys(group.ring, name.id))


def _votes(taxels: frozenset[int], owner: dict[int, int]) -> Counter[int]:
    """How many of ``taxels`` each id owns."""
    return Counter([owner[taxel] for taxel in taxels if taxel in owner])
