"""Which plots a person wants, in which order, and which of them in windows of their own. No Qt.

``PlotKey`` names a plot: a standard one, or one of a taxel, contact, link, joint, limit or kind of event.
``PlotChoice`` is what is shown; until a person chooses among the standard ones, those are shown that the controller
calls for.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import pairwise

from tactile_maps.control.limit_texts import limit_name
from tactile_maps.control.motion.limits import LimitKind

_RANGE = re.compile(r"(\d{1,9})(?:-(\d{1,9}))?")
_MOST = 1_000_000
"""Taxels in one group: no skin has more, and a settings' file that says so is not believed."""


class PlotKind(Enum):
    """What a plot is about; the values stand in the settings' file and in tests."""

    FORCE = "force"
    ERROR = "error"
    SPEED = "speed"
    LIMITS = "limits"
    PRESSURE = "pressure"
    TIME = "ms"
    EVENTS = "events"
    TAXEL = "taxel"
    CONTACT = "contact"
    LINK = "link"
    JOINT = "joint"
    JOINT_SPEED = "joint-speed"
    LIMIT = "limit"
    EVENT = "event"
    GROUP_FORCE = "group-force"
    GROUP_PRESSURE = "group-pressure"


@dataclass(frozen=True)
class TaxelGroup:
    """Taxels under one name.

    Attributes:
        name: What a person calls it.
        taxels: Their numbers, rising, at least one.
    """

    name: str
    taxels: tuple[int, ...]

    @property
    def text(self) -> str:
        """Like ``palm=3-9,12``."""
        return f"{self.name}={_ranges(self.taxels)}"

    @classmethod
    def parse(cls, text: str) -> TaxelGroup | None:
        """From such a text; None where that names no group."""
        name, _, said = text.rpartition("=")
        found = [_RANGE.fullmatch(part) for part in said.split(",")]
        spans = [(int(one[1]), int(one[2] or one[1])) for one in found if one is not None]
        if not name or len(spans) != len(found) or sum(max(last - first, 0) + 1 for first, last in spans) > _MOST:
            return None
        taxels = sorted({taxel for first, last in spans for taxel in range(first, last + 1)})
        return cls(name, tuple(taxels)) if taxels else None


def _ranges(taxels: Iterable[int]) -> str:
    numbers = sorted(set(taxels))
    breaks = [index for index, (one, other) in enumerate(pairwise(numbers), 1) if other != one + 1]
    runs = [numbers[start:end] for start, end in pairwise((0, *breaks, len(numbers)))]
    return ",".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs)


@dataclass(frozen=True)
class PlotKey:
    """One plot.

    Attributes:
        kind: What it is about.
        of: Number of the taxel or contact, name of the link, joint, limit or kind of event, a ``TaxelGroup`` as text;
            empty for a standard plot.
    """

    kind: PlotKind
    of: str = ""

    @property
    def text(self) -> str:
        """Like ``force`` or ``joint:elbow``."""
        return f"{self.kind.value}:{self.of}" if self.of else self.kind.value

    @classmethod
    def parse(cls, text: str) -> PlotKey | None:
        """From such a text; None where that names no plot."""
        kind, _, of = text.partition(":")
        known = {one.value: one for one in PlotKind}
        if kind not in known or bool(of) is not (known[kind] in _WITH_SUBJECT):
            return None
        if known[kind] is PlotKind.LIMIT and of not in [limit.value for limit in LimitKind]:
            return None
        if known[kind] in OF_GROUPS and TaxelGroup.parse(of) is None:
            return None
        numbered = known[kind] in (PlotKind.TAXEL, PlotKind.CONTACT)
        return None if numbered and not of.isdecimal() else cls(known[kind], of)

    @property
    def title(self) -> str:
        """For people, without a unit."""
        name = self.of.replace("_", " ")
        match self.kind:
            case PlotKind.TAXEL | PlotKind.CONTACT:
                return f"{self.kind.value.capitalize()} {name}"
            case PlotKind.LINK:
                return f"Force on {name}"
            case PlotKind.JOINT:
                return f"Joint {name}"
            case PlotKind.JOINT_SPEED:
                return f"Speed of joint {name}"
            case PlotKind.LIMIT:
                words = limit_name(LimitKind(self.of))
                return f"Limit: {words}"
            case PlotKind.EVENT:
                return f"Events: {name}"
            case PlotKind.GROUP_FORCE:
                return f"Force on {self.of.rpartition('=')[0]}"
            case PlotKind.GROUP_PRESSURE:
                return f"Pressure on {self.of.rpartition('=')[0]}"
        return _TITLES[self.kind]


_TITLES = {
    PlotKind.FORCE: "Force",
    PlotKind.ERROR: "Error on the map",
    PlotKind.SPEED: "Max joint speed",
    PlotKind.LIMITS: "Limits",
    PlotKind.PRESSURE: "Pressure",
    PlotKind.TIME: "Time per tick",
    PlotKind.EVENTS: "Contact events",
}
OF_GROUPS = frozenset({PlotKind.GROUP_FORCE, PlotKind.GROUP_PRESSURE})
_WITH_SUBJECT = frozenset(PlotKind) - frozenset(_TITLES)
STANDARD = tuple(PlotKey(kind) for kind in _TITLES)
"""From left to right, where nobody has moved them."""

Rectangle = tuple[int, int, int, int]
"""Left, top, width and height on the screen [px]."""


@dataclass(frozen=True)
class PlotChoice:
    """What is shown.

    Attributes:
        order: All standard plots and those that were added, from left to right.
        chosen: The standard ones that are shown; None for those that the controller calls for.
        windows: The plots that stand in windows of their own, and where.
    """

    order: tuple[PlotKey, ...] = STANDARD
    chosen: frozenset[PlotKey] | None = None
    windows: Mapping[PlotKey, Rectangle | None] = field(default_factory=dict)

    def shown(self, called_for: Collection[PlotKey]) -> tuple[PlotKey, ...]:
        """The plots that are shown where the controller calls for these."""
        standard = called_for if self.chosen is None else self.chosen
        return tuple(key for key in self.order if key in standard or key not in STANDARD)

    def with_plot(self, key: PlotKey, called_for: Collection[PlotKey]) -> PlotChoice:
        """One more plot; an added one comes last."""
        if key in self.shown(called_for):
            return self
        if key in STANDARD:
            standard = frozenset(called_for) if self.chosen is None else self.chosen
            return replace(self, chosen=standard | {key})
        return replace(self, order=(*self.order, key))

    def without(self, key: PlotKey, called_for: Collection[PlotKey]) -> PlotChoice:
        """One less."""
        windows = {one: where for one, where in self.windows.items() if one != key}
        if key not in STANDARD:
            return replace(self, order=tuple(one for one in self.order if one != key), windows=windows)
        standard = frozenset(called_for) if self.chosen is None else self.chosen
        return replace(self, chosen=standard - {key}, windows=windows)

    def moved(self, key: PlotKey, before: PlotKey | None) -> PlotChoice:
        """``key`` stands left of ``before``, or last."""
        if key == before or key not in self.order:
            return self
        rest = [one for one in self.order if one != key]
        rest.insert(rest.index(before) if before in rest else len(rest), key)
        return replace(self, order=tuple(rest))

    def with_window(self, key: PlotKey, where: Rectangle | None) -> PlotChoice:
        """``key`` stands in a window of its own."""
        return replace(self, windows={**self.windows, key: where})

    def without_window(self, key: PlotKey) -> PlotChoice:
        """``key`` stands among the others again."""
        return replace(self, windows={one: where for one, where in self.windows.items() if one != key})

    def to_text(self) -> str:
        """For the settings' file; plots of single contacts end with the session and are left out."""
        order = [key for key in self.order if key.kind is not PlotKind.CONTACT]
        said = {
            "order": [key.text for key in order],
            "chosen": None if self.chosen is None else sorted(key.text for key in self.chosen),
            "windows": {key.text: where for key, where in self.windows.items() if key in order},
        }
        return json.dumps(said)

    @classmethod
    def from_text(cls, text: str) -> PlotChoice:
        """From the settings' file; what says nothing that is known is left out."""
        try:
            said = json.loads(text)
        except ValueError:
            return cls()
        if not isinstance(said, dict):
            return cls()
        order = dict.fromkeys(_keys(said.get("order")))
        chosen = said.get("chosen")
        windows = said.get("windows")
        places = windows if isinstance(windows, dict) else {}
        return cls(
            (*order, *(key for key in STANDARD if key not in order)),
            None if chosen is None else frozenset(_keys(chosen)) & frozenset(STANDARD),
            {key: _rectangle(places[key.text]) for key in _keys(list(places))},
        )


def _keys(texts: object) -> list[PlotKey]:
    known = texts if isinstance(texts, list) else []
    found = (PlotKey.parse(text) for text in known if isinstance(text, str))
    return [key for key in found if key is not None]


def _rectangle(said: object) -> Rectangle | None:
    if isinstance(said, list) and len(said) == 4 and all(isinstance(number, int) for number in said):
        left, top, width, height = said
        return left, top, width, height
    return None
