"""Tracking of contact regions: ids are kept through motion, merging, splitting and short absence.

``RegionTracker`` assigns ids by shared taxels. ``TrackMemory`` stores lost contacts while they may come back with the
same id. ``ContactMotions`` stores the contacts that merged, and identifies them when they part, by motion and force.

A finger that slides over a gap between taxels is not lifted, although no taxel reads it; the same holds between two
samples of a slow skin. A contact that comes back soon enough, no farther away than a finger can have moved, therefore
keeps its id. A contact is released only when it is not awaited any more (``events``).

The waiting time depends on the contact. A wide contact is not lost between taxels: it is awaited as long as one reading
may be missing. Where taxels have gaps, a contact of one or two taxels may be in a gap, so it is awaited until it has
crossed the gap, but only next to its old place. At the same place it is another tap.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.contacts.detection.regions import TaxelGroup
from tactile_maps.core.arrays import FloatArray
from tactile_maps.skin.model.skin import Skin

DWELL = 0.05
"""Waiting time for any contact [s]: less than the 70 ms between two of the fastest taps, 7 a second."""
MISSED = 1.5
"""The same in samples of a slow skin: one missing sample is not a release, two are."""
GAP = 0.3
"""Waiting time for a narrow contact [s]: a stroke at 5 cm/s crosses a gap of 15 mm."""
NARROW = 2
"""Largest number of touched taxels of a narrow contact."""
SPEED = 0.2
"""Largest speed of a finger over the skin [m/s]; strokes are usually made at 0.01 to 0.1 m/s."""


class _LostTrack(NamedTuple):
    """Lost contact: id, link, taxels, time of the loss and time until which it may come back [s]."""

    id: int
    link: str
    group: TaxelGroup
    left: float
    until: float


class TrackMemory:
    """Lost contacts that may come back. Mutable; ``reset`` forgets them.

    Args:
        skin: The skin.
        body: (taxels, 3) positions on it [m], each in its link's frame.

    Attributes:
        waits: Whether contacts are awaited at all.
        gaps: Whether there are gaps without sensing between the taxels.
        period: Period of the skin's samples [s], the largest additional age of a reading; 0 for none.
    """

    def __init__(self, skin: Skin, body: FloatArray) -> None:
        self._body = body
        self._links = [skin.patches[patch].link for patch in skin.patch_of.tolist()]
        self.waits = False
        self.gaps = False
        self.period = 0.0
        self.reset()

    def reset(self) -> None:
        """Forget all contacts."""
        self._gone: list[_LostTrack] = []

    @property
    def dwell(self) -> float:
        """Waiting time for a wide contact [s]."""
        return max(DWELL, MISSED * self.period)

    def lose(self, id_: int, group: TaxelGroup, now: float) -> None:
        """Store the contact ``id_``, last on ``group``, as lost at the time ``now`` [s]."""
        if self.waits:
            narrow = self.gaps and len(group.core) <= NARROW
            wait = max(self.dwell, GAP + self.period) if narrow else self.dwell
            self._gone.append(_LostTrack(id_, self._links[min(group.core)], group, now, now + wait))

    def find(self, group: TaxelGroup, now: float) -> int | None:
        """Remove and return the nearest lost contact that may have returned on ``group``, or None.

        Cost: 0.1 µs without lost contacts, otherwise 50 µs for each.
        """
        near = [(apart, gone) for gone in self._waiting(now) if (apart := self._apart(gone, group, now)) is not None]
        if not near:
            return None
        back = min(near, key=lambda pair: (pair[0], pair[1].id))[1]
        self._gone.remove(back)
        if now - back.left >= self.dwell and back.group.core & group.core:
            return None  # released and tapped again
        return back.id

    def may_return(self, now: float) -> Mapping[int, str]:
        """Return the links of lost contacts by id. Cost: 0.1 µs without lost contacts."""
        return {gone.id: gone.link for gone in self._waiting(now)} if self._gone else {}

    def _waiting(self, now: float) -> list[_LostTrack]:
        self._gone = [gone for gone in self._gone if now < gone.until]
        return self._gone

    def _apart(self, gone: _LostTrack, group: TaxelGroup, now: float) -> float | None:
        """Return the distance from old taxels and ring to the nearest new taxel [m]; None if too far for a finger."""
        after = sorted(group.core)
        if self._links[after[0]] != gone.link:
            return None
        away, _ = cKDTree(self._body[sorted(gone.group.core | gone.group.ring)]).query(self._body[after])
        apart = float(away.min())
        return apart if apart <= SPEED * (now - gone.left + self.period) else None


PARTED = 5.0
"""Time after a merge [s] from which parts are not identified: the larger part keeps the id."""
_WINDOW = 0.2
"""Time over which the velocity before a merge is computed [s]."""
_SETTLED = 0.05
"""A contact that merges again within this time [s] after it parted keeps what was known before: at first its force and
velocity are disturbed by the other contact."""
_SPACING = 0.005
_MOST_SAMPLES = 64
_PLACE_SD = 0.5
"""Standard deviation of a predicted place, as a share of the distance of the parts."""
_FORCE_SD = 0.13
"""Standard deviation of the logarithm of a force by the other contact close to it; its own scatter comes on top."""
_MOTION_LIMIT = 4.0
"""Most that motion counts against an assignment: the evidence of forces that differ by a fifth. Fingers turn back more
often than they change their forces while they touch each other."""
_MOST_ASSIGNMENTS = 1024


class Measured(NamedTuple):
    """Centre of pressure (3,) [m], link frame, and force [N] of a contact."""

    centre: FloatArray
    force: float


class _Motion(NamedTuple):
    """Motion of a contact before it merged: (3,) place [m] and velocity [m/s] at the ``time`` [s]; mean force [N].

    ``scatter`` is the variance of the force as a share of its square.
    """

    time: float
    place: FloatArray
    velocity: FloatArray
    force: float
    scatter: float

    def predicted(self, now: float) -> FloatArray:
        return self.place + (now - self.time) * self.velocity


class ContactMotions:
    """Motion and force of contacts, and the contacts inside merged regions. Mutable; ``reset`` forgets them.

    When a merged region parts, each assignment of its contacts to the parts has a cost: the squared distances of the
    parts from the places that constant velocity predicts, and the squared logarithms of their forces over those before
    the merge. The assignment with the least cost is taken. Motion alone cannot distinguish contacts that cross from
    contacts that turn back; where the forces are equal, contacts that turn back are exchanged.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all contacts."""
        self._paths: dict[int, deque[tuple[float, Measured]]] = {}
        self._before: dict[int, _Motion] = {}
        self._inside: dict[int, dict[int, _Motion]] = {}  # by id of the merged region

    def observe(self, now: float, contacts: Iterable[tuple[int, Measured]]) -> None:
        """Record the contacts at the time ``now`` [s]. Cost: 1 µs a contact."""
        paths = self._paths
        self._paths = {}
        for id_, measured in contacts:
            self._paths[id_] = path = paths.get(id_) or deque(maxlen=_MOST_SAMPLES)
            if not path or now - path[-1][0] >= _SPACING:
                path.append((now, measured))

    def inside(self, id_: int, now: float) -> frozenset[int]:
        """Return the ids of the contacts in a region; its own alone where none merged into it recently."""
        motions = self._inside.get(id_, {})
        return (
            frozenset(motions)
            if motions and now - min(m.time for m in motions.values()) < PARTED
            else frozenset((id_,))
        )

    def keep(self, contents: Mapping[int, frozenset[int]]) -> None:
        """Store the contacts in each region from now on; ``contents`` has the ids of contacts by that of the region."""
        known = {id_: motion for inside in self._inside.values() for id_, motion in inside.items()}
        self._inside = {}
        for region, ids in contents.items():
            motions = {id_: known.get(id_) or self._motion(id_) for id_ in ids} if len(ids) > 1 else {}
            sure = {id_: motion for id_, motion in motions.items() if motion is not None}
            if len(sure) > 1 and region in sure:
                self._inside[region] = sure
        parted = {id_ for ids in contents.values() if len(ids) == 1 for id_ in ids}
        self._before = {id_: m for id_, m in (self._before | known).items() if id_ in parted}
        for id_ in known:  # observed so far is the merged region
            self._paths.pop(id_, None)

    def assigned(self, region: int, parts: Sequence[Measured], now: float) -> list[frozenset[int]] | None:
        """Return the contacts in each of the parts of a merged region; None where there are too many to compare.

        Each part gets at least one contact; if there are more parts than contacts, no part gets two.
        """
        motions = self._inside[region]
        ids = list(motions)
        if len(parts) ** len(ids) > _MOST_ASSIGNMENTS:
            return None
        least = min(len(parts), len(ids))
        every = [one for one in product(range(len(parts)), repeat=len(ids)) if len(set(one)) == least]
        costs = np.array([_costs(one, list(motions.values()), parts, now) for one in every])
        total = np.minimum(costs[:, 0] - costs[:, 0].min(), _MOTION_LIMIT) + costs[:, 1]
        best = every[int(total.argmin())]
        return [frozenset(id_ for id_, part in zip(ids, best, strict=True) if part == k) for k in range(len(parts))]

    def _motion(self, id_: int) -> _Motion | None:
        """Motion of a contact that merges now; None if it was never observed."""
        path = self._paths.get(id_)
        if not path:
            return self._before.get(id_)
        last = path[-1][0]
        if id_ in self._before and last - path[0][0] < _SETTLED:
            return self._before[id_]
        times = np.array([time for time, _ in path if time >= last - _WINDOW]) - last
        recent = [measured for _, measured in path][-len(times) :]
        places = np.array([measured.centre for measured in recent])
        spread = times - times.mean()
        squared = float(spread @ spread)
        velocity = spread @ places / squared if squared > 0 else np.zeros(3)
        forces = np.array([measured.force for _, measured in path])
        force = float(forces.mean())
        return _Motion(
            last, places.mean(axis=0) - times.mean() * velocity, velocity, force, float(forces.var()) / force**2
        )


def _costs(
    assignment: tuple[int, ...], motions: Sequence[_Motion], parts: Sequence[Measured], now: float
) -> tuple[float, float]:
    """Return the costs of motion and of force of an assignment, the number of the part of each contact."""
    used = sorted(set(assignment))
    members = [[m for m, own in zip(motions, assignment, strict=True) if own == part] for part in used]
    before = np.array([sum(m.force for m in own) for own in members])
    predicted = np.array([sum(m.force * m.predicted(now) for m in own) for own in members]) / before[:, None]
    centres = np.array([parts[part].centre for part in used])
    apart = centres - centres.mean(axis=0)
    scale = 2 * float(np.sqrt((apart**2).sum(axis=1).mean()))
    off = float(((centres - predicted) ** 2).sum()) / (_PLACE_SD * scale) ** 2 if scale > 0 else 0.0
    grown = np.log(np.array([parts[part].force for part in used]) / before)
    variance = _FORCE_SD**2 + sum(m.scatter for m in motions) / len(motions)
    return off, float(((grown - grown.mean()) ** 2).sum()) / variance


class TrackId(NamedTuple):
    """Identity of a region.

    Attributes:
        id: Its id.
        merged: Ids that merged into it at this frame.
        split_from: Id from which it split off at this frame; None if there is none.
    """

    id: int
    merged: tuple[int, ...] = ()
    split_from: int | None = None


Measure = Callable[[Sequence[TaxelGroup]], list[Measured]]


class RegionTracker:
    """Ids of groups of taxels, frame by frame. Mutable; ``reset`` forgets them all.

    A region continues the one with which it shares most touched taxels. If it has moved farther, it continues one in
    whose ring it is, or else one whose ring touches its own ring; in these two cases only if no other region continues
    that one. If one region continues several, they have merged and the oldest keeps its id. If a merged region leaves
    several parts, its contacts get their ids back (``ContactMotions``). If any other region leaves several parts, it
    has split and the largest part keeps the id.

    A contact that jumps by more than its own size and two rings between two frames is new. A contact that comes back is
    new unless the memory contains it.

    Args:
        memory: Lost contacts; by default no contact comes back.

    Attributes:
        motions: Motion of the contacts. Only contacts that are observed there are identified after a merge.
    """

    def __init__(self, memory: TrackMemory | None = None) -> None:
        self._memory = memory
        self.motions = ContactMotions()
        self.reset()

    def reset(self) -> None:
        """Forget all contacts; ids start at 1 again."""
        self._core: dict[int, int] = {}  # id by touched taxel
        self._ring: dict[int, int] = {}  # id by ring taxel
        self._groups: dict[int, TaxelGroup] = {}  # by id
        self._next = 1
        self.motions.reset()
        if self._memory is not None:
            self._memory.reset()

    def assign(
        self, groups: Sequence[TaxelGroup], *, now: float = 0.0, measure: Measure | None = None
    ) -> list[TrackId]:
        """Return the identities of ``groups`` in their order. Cost: 0.2 µs a taxel.

        Args:
            groups: Groups of touched taxels.
            now: Present time [s]; used for contacts that come back or part.
            measure: Centres and forces of groups; without it parts of merged regions are not identified.
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
        for old in heir:
            claims[heir[old][1]].append(old)
        self._lose(heir.keys(), now)
        parted = self._parted(groups, claims, shared, now, measure) if measure is not None else {}
        contents = [
            frozenset[int]().union(
                *[self.motions.inside(old, now) for old in claim if old not in parted],
                *[parts[number] for parts in parted.values() if number in parts],
            )
            for number, claim in enumerate(claims)
        ]
        names = [
            self._identify(ids, vote, group, now) for ids, vote, group in zip(contents, shared, groups, strict=True)
        ]
        self.motions.keep({name.id: ids | {name.id} for name, ids in zip(names, contents, strict=True)})
        self._remember(groups, names)
        return names

    def contact_of(self, group: TaxelGroup) -> int | None:
        """Return the id of the earlier contact that had most of the touched taxels of ``group``, or on whose ring they
        are; None for a new contact.
        """
        return _parent(_votes(group.core, self._core) or _votes(group.core, self._ring))

    def _moved(self, group: TaxelGroup, placed: set[int]) -> Counter[int]:
        """Return the votes of a group without shared touched taxels, for contacts that are not ``placed`` elsewhere."""
        if placed.issuperset(self._core.values()):
            return Counter()
        near = _votes(group.core, self._ring)
        far = near or _votes(group.ring, self._core) or _votes(group.ring, self._ring)
        return Counter({old: count for old, count in far.items() if old not in placed})

    def _lose(self, kept: Set[int], now: float) -> None:
        """Store contacts that no region continues as lost; merged contacts are continued."""
        if self._memory is not None:
            for old, group in self._groups.items():
                if old not in kept:
                    self._memory.lose(old, group, now)

    def _parted(
        self,
        groups: Sequence[TaxelGroup],
        claims: Sequence[Sequence[int]],
        shared: Sequence[Counter[int]],
        now: float,
        measure: Measure,
    ) -> dict[int, dict[int, frozenset[int]]]:
        """Return the contacts in each group, by merged region that left several groups and by number of the group."""
        parted = {}
        for old in self._groups:
            if len(self.motions.inside(old, now)) < 2:
                continue
            heirs = [n for n, claim in enumerate(claims) if old in claim or (not claim and _parent(shared[n]) == old)]
            if len(heirs) > 1:
                found = self.motions.assigned(old, measure([groups[n] for n in heirs]), now)
                if found is not None:
                    parted[old] = dict(zip(heirs, found, strict=True))
        return parted

    def _identify(self, ids: frozenset[int], vote: Counter[int], group: TaxelGroup, now: float) -> TrackId:
        """Return the name of a group that contains the contacts ``ids``."""
        parent = _parent(vote)
        if ids:
            name = min(ids)
            merged = tuple(sorted(old for old in ids if old in self._groups and old != name))
            return TrackId(name, merged, None if name in self._groups else parent)
        back = self._memory.find(group, now) if self._memory is not None and parent is None else None
        if back is not None:
            return TrackId(back)
        self._next += 1
        return TrackId(self._next - 1, (), parent)

    def _remember(self, groups: Sequence[TaxelGroup], names: Sequence[TrackId]) -> None:
        self._core = {}
        self._ring = {}
        self._groups = {name.id: group for group, name in zip(groups, names, strict=True)}
        for group, name in zip(groups, names, strict=True):
            self._core.update(dict.fromkeys(group.core, name.id))
            self._ring.update(dict.fromkeys(group.ring, name.id))


def _parent(vote: Counter[int]) -> int | None:
    """Return the id with the most votes, of equals the smallest; None without votes."""
    return min(vote, key=lambda old: (-vote[old], old), default=None)


def _votes(taxels: frozenset[int], owner: dict[int, int]) -> Counter[int]:
    """Return the number of ``taxels`` that each id owns."""
    return Counter([owner[taxel] for taxel in taxels if taxel in owner])
