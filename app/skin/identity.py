"""What a robot's own electronics call a taxel: its id, its module, and its channel on that module's board.

Inside the program a taxel is its running number through the skin. That number changes with the file, the fit and the
order of the patches; the identity here is what a robot's readings are tied to, and goes along unchanged. Ids may repeat
where several boards count for themselves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import IntArray, freeze_arrays
from app.core.errors import SkinError

LARGEST_NUMBER = 2**31 - 1
"""Of an id, a module or a channel: what the boards count in."""
IDENTITY_FIELDS = ("ids", "modules", "channels")


@dataclass(frozen=True)
class TaxelName:
    """The identity of one taxel; None where it is not known."""

    id: int | None = None
    module: int | None = None
    channel: int | None = None

    def __str__(self) -> str:
        """``id 87012, module 14, channel 3``; empty where nothing is known."""
        parts = (("id", self.id), ("module", self.module), ("channel", self.channel))
        return ", ".join(f"{word} {number}" for word, number in parts if number is not None)


@dataclass(frozen=True, eq=False)
class TaxelIdentity:
    """The identity of each of n taxels; an array is None where nothing states it.

    Attributes:
        ids: (n,) hardware ids, as stated; they may repeat.
        modules: (n,) the module, or board, that carries each taxel.
        channels: (n,) the place of each taxel among those of its module.

    Raises:
        SkinError: An array is not of one axis, they differ in length, or a number is not from 0 to 2³¹ - 1.
    """

    ids: IntArray | None = None
    modules: IntArray | None = None
    channels: IntArray | None = None

    def __post_init__(self) -> None:
        freeze_arrays(self, *IDENTITY_FIELDS, dtype=np.int64)
        count: int | None = None
        for field in IDENTITY_FIELDS:
            values: IntArray | None = getattr(self, field)
            if values is None:
                continue
            if values.ndim != 1 or len(values) != (len(values) if count is None else count):
                raise SkinError("the numbers of rows or columns do not fit", place=field, value=values.shape)
            count = len(values)
            bad = (values < 0) | (values > LARGEST_NUMBER)
            if bad.any():
                row = int(bad.argmax())
                problem = "a number is negative" if values[row] < 0 else f"a number is above {LARGEST_NUMBER}"
                raise SkinError(problem, place=f"{field}, row {row}", value=int(values[row]))

    def __len__(self) -> int:
        """The number of taxels, 0 where nothing is known."""
        return next((len(values) for values in (self.ids, self.modules, self.channels) if values is not None), 0)

    @property
    def known(self) -> bool:
        """Whether anything is."""
        return not (self.ids is None and self.modules is None and self.channels is None)

    def select(self, rows: IntArray) -> TaxelIdentity:
        """Of the taxels in ``rows`` (k,), in that order."""
        return TaxelIdentity(*(None if values is None else values[rows] for values in self._arrays()))

    def name(self, row: int) -> TaxelName:
        """Of one taxel."""
        return TaxelName(*(None if values is None else int(values[row]) for values in self._arrays()))

    def _arrays(self) -> tuple[IntArray | None, ...]:
        return self.ids, self.modules, self.channels


NO_IDENTITY = TaxelIdentity()


def join_identities(parts: Sequence[TaxelIdentity]) -> TaxelIdentity:
    """Of the taxels of all ``parts``, one after the other; an array that one of them lacks is None."""
    columns = ([getattr(part, field) for part in parts] for field in IDENTITY_FIELDS)
    return TaxelIdentity(
        *(np.concatenate(arrays) if arrays and all(a is not None for a in arrays) else None for arrays in columns)
    )


def identity_summary(identity: TaxelIdentity) -> dict[str, dict[str, int]]:
    """For each array that is known: how many different numbers, the first and the last, and for ids how many repeat."""
    found = {}
    for field in IDENTITY_FIELDS:
        values: IntArray | None = getattr(identity, field)
        if values is not None and len(values):
            counts = np.unique(values, return_counts=True)[1]
            repeated = int((counts > 1).sum()) if field == "ids" else 0
            found[field] = {
                "different": len(counts), "first": int(values.min()), "last": int(values.max()), "repeated": repeated
            }  # fmt: skip
    return found


def identity_text(summary: Mapping[str, Mapping[str, int]]) -> str:
    """``ids 86999 to 87438 (440), modules 0 to 63 (44)``: an ``identity_summary`` in words; empty for nothing."""
    parts = []
    for field, found in summary.items():
        again = f", {found['repeated']} repeated" if found["repeated"] else ""
        parts.append(f"{field} {found['first']} to {found['last']} ({found['different']}{again})")
    return ", ".join(parts)


def number_ranges(numbers: Sequence[int] | IntArray, *, most: int = 8) -> str:
    """Whole numbers in few words, ``0-3, 12, 20-23``; beyond ``most`` ranges it says how many more numbers there are.

    Args:
        numbers: In any order; each is named once.
        most: Ranges that are written out.
    """
    values = np.unique(np.asarray(numbers, dtype=np.int64))
    runs = np.split(values, np.flatnonzero(np.diff(values) > 1) + 1) if len(values) else []
    texts = [f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]) for run in runs[:most]]
    left = sum(map(len, runs[most:]))
    return ", ".join(texts) + (f" and {left} more" if left else "")
