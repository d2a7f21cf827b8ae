"""Faults of channels and swapped parts, judged from the readings of a guided check."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from tactile_maps.core.arrays import BoolArray, IntArray
from tactile_maps.live.checking.parts import part_numbers
from tactile_maps.live.checking.skin_check import Outcome, SkinCheck

_HELD = 5
"""Number of successive equal readings at its largest change after which a channel may be saturated."""
_QUIETER = 3
"""Ratio of that number to the one at rest above which the noise is cut off."""
_CONVERTER_BITS = range(8, 33)
"""Numbers of bits of converters, whose largest values are full scale."""
_CLEAR = 0.5
"""A channel is dead only if it would be felt at this share of the largest change of its neighbours."""
_OPPOSITE = 2.0
"""A channel is inverted if it changes so many times more against the skin's direction than along it,"""
_STRONG = 0.25
"""and by at least this share of the median change of its part."""


class ChannelFault(StrEnum):
    """Fault of a channel; the value is displayed.

    ``UNHEARD``: no value arrived. ``NOT_FELT``: neither it nor most of its neighbours were felt; press there again.
    """

    UNHEARD = "not received"
    DEAD = "dead"
    STUCK = "stuck"
    NOISY = "noisy"
    SATURATED = "saturated"
    INVERTED = "inverted"
    SWAPPED = "swapped"
    NOT_FELT = "not felt"


FAULT_TEXTS = {
    ChannelFault.UNHEARD: "no value arrived",
    ChannelFault.DEAD: "no response, although its part or most of its neighbours were pressed",
    ChannelFault.STUCK: "never changed, and is above all values of its neighbours",
    ChannelFault.NOISY: "noise at rest more than 8 times the median of the skin",
    ChannelFault.SATURATED: "remained at one value, its largest change, while it was pressed",
    ChannelFault.INVERTED: "changes against the direction of the others under pressure",
    ChannelFault.SWAPPED: "responds in place of another channel",
    ChannelFault.NOT_FELT: "not pressed, as far as its neighbours show: press there again",
}
"""Meaning of each fault."""


@dataclass(frozen=True)
class Swap:
    """Channels or parts that respond in place of each other.

    Attributes:
        first: Taxels of one.
        second: Taxels of the other.
        parts: Names of two parts whose channels all respond in place of each other; empty for single channels.
    """

    first: tuple[int, ...]
    second: tuple[int, ...]
    parts: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Verdicts:
    """Verdicts of a check.

    Attributes:
        faults: (taxels,) whether each has a fault, by fault.
        swaps: Channels or parts that respond in place of each other.
        falls: Whether the values of the whole skin fall under pressure.
    """

    faults: dict[ChannelFault, BoolArray]
    swaps: tuple[Swap, ...]
    falls: bool

    def of(self, taxel: int) -> tuple[ChannelFault, ...]:
        """Return the faults of a taxel."""
        return tuple(fault for fault, those in self.faults.items() if those[taxel])

    @property
    def faulty(self) -> IntArray:
        """(k,) taxels with a fault; those that were only not pressed do not count."""
        some = np.zeros(len(self.faults[ChannelFault.DEAD]), dtype=bool)
        for fault, those in self.faults.items():
            if fault is not ChannelFault.NOT_FELT:
                some |= those
        return np.flatnonzero(some)


def verdicts_of(check: SkinCheck) -> Verdicts:
    """Return the verdicts of a check; before its end, of what was pressed so far."""
    swaps = (*_swapped_across(check), *(Swap((one.first,), (one.second,)) for one in check.swapped))
    swapped = np.zeros(len(check.skin), dtype=bool)
    for swap in swaps:
        swapped[[*swap.first, *swap.second]] = True
    falls, inverted = _inverted(check)
    silent, unpressed = _silent(check, swapped)
    stuck = silent & ~check.changed & _above_neighbours(check, falls=falls)
    faults = {
        ChannelFault.UNHEARD: ~check.heard,
        ChannelFault.DEAD: silent & ~stuck,
        ChannelFault.STUCK: stuck,
        ChannelFault.NOISY: check.noisy,
        ChannelFault.SATURATED: _saturated(check),
        ChannelFault.INVERTED: inverted,
        ChannelFault.SWAPPED: swapped,
        ChannelFault.NOT_FELT: unpressed,
    }
    return Verdicts(faults, swaps, falls)


def _silent(check: SkinCheck, swapped: BoolArray) -> tuple[BoolArray, BoolArray]:
    """(taxels,) channels without a response although they were pressed, and those that were probably not pressed."""
    felt = check.felt
    pairs = check.skin.neighbours
    count = len(felt)
    around = np.bincount(pairs[:, 0], felt[pairs[:, 1]], count) + np.bincount(pairs[:, 1], felt[pairs[:, 0]], count)
    degree = np.bincount(pairs.ravel(), minlength=count)
    pressed = (degree > 0) & (2 * around >= degree)
    ends = np.concatenate([pairs, pairs[:, ::-1]])
    strongest = np.zeros(count)
    np.maximum.at(strongest, ends[:, 0], np.maximum(check.rise, check.fall)[ends[:, 1]])
    pressed &= check.limit <= _CLEAR * strongest  # a weaker touch would be lost in the channel's own noise
    reached = np.zeros(count, dtype=bool)
    for part, result in zip(check.parts, check.results, strict=True):
        own = part.taxels
        if result.outcome is Outcome.NOTHING or len(own) == 1:
            pressed[own] |= result.outcome not in (Outcome.OPEN, Outcome.SKIPPED)
        if result.outcome is Outcome.FELT:  # a constant value does not even show the noise of its part
            lively = bool(check.changed[own].mean() >= 0.5) if check.noise[own].any() else False
            pressed[own] |= lively & ~check.changed[own]
        reached[own] = result.outcome not in (Outcome.OPEN, Outcome.SKIPPED)
    mute = check.heard & ~felt & ~swapped
    dead = np.asarray(mute & pressed & (reached | (not check.settings.ordered)))
    return dead, np.asarray(mute & ~pressed & reached)


def _above_neighbours(check: SkinCheck, *, falls: bool) -> BoolArray:
    """(taxels,) whether the value is above (where values fall under pressure, below) all values of its neighbours."""
    pairs = np.concatenate([check.skin.neighbours, check.skin.neighbours[:, ::-1]])
    around = np.full(len(check.skin), -np.inf)
    np.maximum.at(around, pairs[:, 0], (-check.lowest if falls else check.highest)[pairs[:, 1]])
    value = -check.highest if falls else check.lowest
    return np.asarray(np.isfinite(around) & (value > around))


def _inverted(check: SkinCheck) -> tuple[bool, BoolArray]:
    """Return whether the values fall under pressure, and (taxels,) which channels do the opposite."""
    felt = check.felt
    up = felt & (check.rise >= check.fall)
    falls = 2 * int(up.sum()) < int(felt.sum())
    own, opposite = (check.fall, check.rise) if falls else (check.rise, check.fall)
    size = np.maximum(check.rise, check.fall)
    usual = np.zeros(len(size))
    for part in check.parts:
        those = part.taxels[felt[part.taxels]]
        usual[part.taxels] = np.median(size[those]) if len(those) else np.inf
    if len(check.parts) and all(len(part.taxels) == 1 for part in check.parts):
        usual[:] = np.median(size[felt]) if felt.any() else np.inf
    if 2 * int(up.sum()) == int(felt.sum()):
        return False, np.zeros(len(size), dtype=bool)  # no direction is that of the skin
    return falls, felt & (opposite > _OPPOSITE * own) & (opposite >= _STRONG * usual)


def _saturated(check: SkinCheck) -> BoolArray:
    """(taxels,) whether a channel remained at a limit while it was pressed: without the noise that it has at rest, at a
    converter's largest value, or at 0 if its values fall.
    """
    stays = check.felt & (check.held >= _HELD)
    full = np.isin(check.extreme, [2.0**bits - 1 for bits in _CONVERTER_BITS]) & (check.rise >= check.fall)
    full |= (check.extreme == 0) & (check.fall > check.rise)
    return stays & (full | (check.held >= _QUIETER * check.steady))


def _swapped_across(check: SkinCheck) -> tuple[Swap, ...]:
    """Return channels of different parts that respond in place of each other.

    A channel of part B was felt while part A was requested and not while B was, and channels of A the other way round:
    equal numbers, or most channels of both parts, because channels of swapped parts may be dead.
    """
    if not check.settings.ordered:
        return ()
    part_of = part_numbers(check.skin, check.parts)
    taxels = np.arange(len(part_of))
    strays = check.felt_in & ~check.felt_in[part_of, taxels]
    counts = np.zeros((len(check.parts), len(check.parts)), dtype=np.int64)
    rows, where = np.nonzero(strays)
    np.add.at(counts, (rows, part_of[where]), 1)
    most = 2 * counts > [len(part.taxels) for part in check.parts]
    exchanged = (counts > 0) & (counts == counts.T) | most & most.T
    found = []
    for one, other in np.argwhere(np.triu(exchanged, 1)).tolist():
        first = np.flatnonzero(strays[other] & (part_of == one))
        second = np.flatnonzero(strays[one] & (part_of == other))
        whole = len(first) > 1 and np.array_equal(np.flatnonzero(check.felt_in[other]), first)
        names = (check.parts[one].name, check.parts[other].name) if whole else ()
        found.append(Swap(tuple(first.tolist()), tuple(second.tolist()), names))
    return tuple(found)
