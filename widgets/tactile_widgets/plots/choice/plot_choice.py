"""Plots that the user chose, their order, and which of them have separate windows. No Qt.

``PlotKey`` identifies a plot: a standard one, or one of a taxel, contact, link, joint, limit or kind of event.
``PlotChoice`` lists the shown plots. Until the user chooses among the standard plots, the controller determines which
of them are shown.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import pairwise

from tactile_maps.control.motion.limits import LimitKind

_RANGE = re.compile(r"(\d{1,9})(?:-(\d{1,9}))?")
_MOST = 1_000_000
"""Maximum number of taxels in one group: no skin has more, so a settings file with more is invalid."""


class PlotKind(Enum):
    """Quantity that a plot shows; the values are stored in the settings file and used in tests."""

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
    RASTER = "raster"
    SHEAR = "shear"
    FRICTION = "friction"


@dataclass(frozen=True)
class TaxelGroup:
    """Taxels under one name.

    Attributes:
        name: Name chosen by the user.
        taxels: Taxel numbers in ascending order, at least one.
    """

    name: str
    taxels: tuple[int, ...]

    @property
    def text(self) -> str:
        """Text form, for example ``palm=3-9,12``."""
        return f"{self.name}={_ranges(self.taxels)}"

    @classmethod
    def parse(cls, text: str) -> TaxelGroup | None:
        """Parse the text form of a group; None if it is invalid."""
        name, _, numbers = text.rpartition("=")
        found = [_RANGE.fullmatch(part) for part in numbers.split(",")]
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
    """Identifier of a plot.

    Attributes:
        kind: Quantity that is plotted.
        of: Number of the taxel or contact, name of the link, joint, limit or event kind, or a ``TaxelGroup`` as text;
            empty for a standard plot.
    """

    kind: PlotKind
    of: str = ""

    @property
    def text(self) -> str:
        """Text form, for example ``force`` or ``joint:elbow``."""
        return f"{self.kind.value}:{self.of}" if self.of else self.kind.value

    @classmethod
    def parse(cls, text: str) -> PlotKey | None:
        """Parse the text form of a key; None if it is invalid."""
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
        """Title shown to the user, without a unit."""
        name = self.of.replace("_", " ")
        match self.kind:
            case PlotKind.TAXEL | PlotKind.CONTACT:
                return f"{self.kind.value.capitalize()} {name}"
            case PlotKind.LINK:
                return f"Force on {name}"
            case PlotKind.JOINT:
                return f"Joint {name.removesuffix(' joint')}"
            case PlotKind.JOINT_SPEED:
                return f"Speed of joint {name.removesuffix(' joint')}"
            case PlotKind.LIMIT:
                words = LimitKind(self.of).title
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
    PlotKind.RASTER: "All taxels",
    PlotKind.SHEAR: "Shear force",
    PlotKind.FRICTION: "Friction in use",
}
OF_GROUPS = frozenset({PlotKind.GROUP_FORCE, PlotKind.GROUP_PRESSURE})
_WITH_SUBJECT = frozenset(PlotKind) - frozenset(_TITLES)
RASTER = PlotKey(PlotKind.RASTER)
OF_SHEAR = (PlotKey(PlotKind.SHEAR), PlotKey(PlotKind.FRICTION))
"""Plots of the shear of all contacts: sum of their forces along the skin, and highest friction in use."""
STANDARD = tuple(key for key in map(PlotKey, _TITLES) if key not in (RASTER, *OF_SHEAR))
"""Standard plots in their default order from left to right."""

Rectangle = tuple[int, int, int, int]
"""Left, top, width and height on the screen [px]."""


@dataclass(frozen=True)
class PlotChoice:
    """Plots that are shown.

    Attributes:
        order: All standard and added plots, from left to right.
        chosen: Shown standard plots; None lets the controller determine them.
        windows: Plots in separate windows, with the window geometry.
    """

    order: tuple[PlotKey, ...] = STANDARD
    chosen: frozenset[PlotKey] | None = None
    windows: Mapping[PlotKey, Rectangle | None] = field(default_factory=dict)

    def shown(self, called_for: Collection[PlotKey]) -> tuple[PlotKey, ...]:
        """Return the shown plots, given the standard plots that the controller calls for."""
        standard = called_for if self.chosen is None else self.chosen
        return tuple(key for key in self.order if key in standard or key not in STANDARD)

    def with_plot(self, key: PlotKey, called_for: Collection[PlotKey]) -> PlotChoice:
        """Return the choice with one more plot; a plot that is not a standard one is appended."""
        if key in self.shown(called_for):
            return self
        if key in STANDARD:
            standard = frozenset(called_for) if self.chosen is None else self.chosen
            return replace(self, chosen=standard | {key})
        return replace(self, order=(*self.order, key))

    def without(self, key: PlotKey, called_for: Collection[PlotKey]) -> PlotChoice:
        """Return the choice without a plot."""
        windows = {one: where for one, where in self.windows.items() if one != key}
        if key not in STANDARD:
            return replace(self, order=tuple(one for one in self.order if one != key), windows=windows)
        standard = frozenset(called_for) if self.chosen is None else self.chosen
        return replace(self, chosen=standard - {key}, windows=windows)

    def moved(self, key: PlotKey, before: PlotKey | None) -> PlotChoice:
        """Return the choice with ``key`` moved to the left of ``before``, or to the end."""
        if key == before or key not in self.order:
            return self
        rest = [one for one in self.order if one != key]
        rest.insert(rest.index(before) if before in rest else len(rest), key)
        return replace(self, order=tuple(rest))

    def with_window(self, key: PlotKey, where: Rectangle | None) -> PlotChoice:
        """Return the choice with ``key`` in a separate window."""
        return replace(self, windows={**self.windows, key: where})

    def without_window(self, key: PlotKey) -> PlotChoice:
        """Return the choice with ``key`` back on the board."""
        return replace(self, windows={one: where for one, where in self.windows.items() if one != key})

    def to_text(self) -> str:
        """Return the text for the settings file; plots of single contacts end with the session and are omitted."""
        order = [key for key in self.order if key.kind is not PlotKind.CONTACT]
        stored = {
            "order": [key.text for key in order],
            "chosen": None if self.chosen is None else sorted(key.text for key in self.chosen),
            "windows": {key.text: where for key, where in self.windows.items() if key in order},
        }
        return json.dumps(stored)

    @classmethod
    def from_text(cls, text: str) -> PlotChoice:
        """Read the text from the settings file; unknown entries are ignored."""
        try:
            stored = json.loads(text)
        except ValueError:
            return cls()
        if not isinstance(stored, dict):
            return cls()
        order = dict.fromkeys(_keys(stored.get("order")))
        chosen = stored.get("chosen")
        windows = stored.get("windows")
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


def _rectangle(stored: object) -> Rectangle | None:
    if isinstance(stored, list) and len(stored) == 4 and all(isinstance(number, int) for number in stored):
        left, top, width, height = stored
        return left, top, width, height
    return None
