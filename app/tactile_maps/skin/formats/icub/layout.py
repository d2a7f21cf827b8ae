"""iCub layout files: the hand-drawn map of a patch for the iCub skin viewer.

The format is that of iCubSkinGui (robotology/icub-main, app/skinGui/conf/skinGui): named settings, then under
``[SENSORS]`` one line ``type id x y orientation gain [mirror [layoutNum]]`` per module, in units of about a millimetre
and in degrees. A module is mirrored, then rotated, then moved. With ``layoutNum`` 1 its pads are counted backwards.
Taxels are numbered through the modules in the order of their ids, and a missing id counts as twelve taxels. Taxel
``12 id + pad`` is therefore pad ``pad``, except after a palm, whose 48 pads belong to four boards.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, readonly
from tactile_maps.core.errors import Finding, SkinError, add_finding, errors_in_file
from tactile_maps.core.files import read_bounded_text
from tactile_maps.skin.formats.icub.positions import ROWS_PER_MODULE
from tactile_maps.skin.formats.icub.sensor_kinds import KINDS, TRIANGLE, SensorKind
from tactile_maps.skin.model.taxel_set import MAX_COORDINATE, TaxelSet

MAX_BYTES = 2**20
MAX_ID = 8192
_MILLI = 1e-3
_NUMBERS = ("id", "x", "y", "orientation", "gain", "mirror", "layoutNum")
_FEWEST = 5


@dataclass(frozen=True)
class LayoutModule:
    """Module on a hand-drawn map.

    Attributes:
        number: Number of the module in the patch.
        x: Position of its middle [m].
        y: Position of its middle [m].
        angle: Rotation, counter-clockwise [rad].
        mirrored: Whether x is negated before the rotation.
        gain: Factor for its readings in the viewer.
        kind: Kind of module, with the positions of its pads.
        backwards: Whether its pads are counted from the last.
    """

    number: int
    x: float
    y: float
    angle: float
    mirrored: bool = False
    gain: float = 1.0
    kind: SensorKind = TRIANGLE
    backwards: bool = False

    @property
    def points(self) -> FloatArray:
        """(n, 2) positions of its channels on the map [m]; NaN for channels without a pad."""
        cosine = np.cos(self.angle)
        sine = np.sin(self.angle)
        pads = self.kind.pads * [-1.0 if self.mirrored and self.kind.mirrors else 1.0, 1.0]
        pads = pads[::-1] if self.backwards else pads
        return pads @ np.array([[cosine, sine], [-sine, cosine]]) + [self.x, self.y]


@dataclass(frozen=True)
class IcubLayout:
    """Hand-drawn map of a patch.

    Attributes:
        name: Name of the file without its suffix.
        modules: Modules in the order of the file, with distinct numbers.
        findings: Defects that were found while reading.
    """

    name: str
    modules: tuple[LayoutModule, ...]
    findings: tuple[Finding, ...] = field(default=(), compare=False)

    @cached_property
    def starts(self) -> dict[int, int]:
        """Number of the first taxel of each module, by the number of the module."""
        starts = {}
        ahead = 0
        for module in self._in_order:
            starts[module.number] = ROWS_PER_MODULE * module.number + ahead
            ahead += len(module.kind.pads) - ROWS_PER_MODULE
        return starts

    @cached_property
    def numbers(self) -> IntArray:
        """(k,) numbers of the taxels on the map, with thermal pads, in increasing order."""
        channels = [self.starts[m.number] + np.arange(len(m.kind.pads)) for m in self._in_order]
        return readonly(np.concatenate(channels)[self._placed], np.int64)

    @cached_property
    def points(self) -> FloatArray:
        """(k, 2) positions of the taxels on the map [m]."""
        return readonly(np.concatenate([m.points for m in self._in_order])[self._placed])

    @cached_property
    def felt(self) -> BoolArray:
        """(k,) whether each taxel on the map is tactile."""
        felt = [m.kind.felt[::-1] if m.backwards else m.kind.felt for m in self._in_order]
        return readonly(np.concatenate(felt)[self._placed], bool)

    @property
    def _in_order(self) -> list[LayoutModule]:
        return sorted(self.modules, key=lambda module: module.number)

    @property
    def _placed(self) -> BoolArray:
        """Channels that have a pad."""
        return np.isfinite(np.concatenate([m.points for m in self._in_order])[:, 0])


def read_icub_layout(path: str | Path) -> IcubLayout:
    """Return the layout in a file.

    Modules of unknown kinds and repeated modules are left out, with findings.

    Raises:
        SkinError: The file cannot be read, a line is invalid, or no module is of a known kind.
    """
    path = Path(path)
    modules = list[LayoutModule]()
    unknown = Counter[str]()
    inside = False
    text = read_bounded_text(path, most=MAX_BYTES, error=SkinError)
    with errors_in_file(path):
        for number, line in enumerate(text.splitlines(), start=1):
            words = line.split()
            if not words or words[0].startswith(("#", "//")):
                continue
            if words[0].startswith("["):
                inside = words[0].upper() == "[SENSORS]"
            elif inside and words[0] in KINDS:
                modules.append(_module(KINDS[words[0]], words[1:], number))
            elif inside:
                unknown[words[0]] += 1
        if not modules:
            remedy = f"Modules of these kinds can be read: {', '.join(KINDS)}"
            value = ", ".join(sorted(unknown)) or None
            raise SkinError("the file has no module of a known kind", value=value, remedy=remedy)
    findings = [
        Finding("unknown-sensor-kind", path.name, f"left out: the positions of the pads of {kind} are unknown", count)
        for kind, count in sorted(unknown.items())
    ]
    return IcubLayout(path.stem, _first_of_each_number(modules, path.name, findings), tuple(findings))


def flat_taxels(layout: IcubLayout) -> TaxelSet:
    """Return the tactile taxels of ``layout`` as a flat skin in the plane of the map, without positions on a body."""
    numbers = layout.numbers[layout.felt]
    points = layout.points[layout.felt]
    modules, channels = np.divmod(numbers, ROWS_PER_MODULE)
    action = "a layout has no positions on a body: its taxels are placed in the plane of the map, one unit is 1 mm"
    return TaxelSet(
        layout.name,
        None,
        numbers,
        np.column_stack([points, np.zeros(len(points))]),
        normals=np.tile([0.0, 0.0, 1.0], (len(points), 1)),
        points=points,
        modules=modules,
        ids=numbers,
        channels=channels,
        findings=(*layout.findings, Finding("map-only", layout.name, action, len(points))),
    )


def apply_layout(taxels: TaxelSet, layout: IcubLayout) -> TaxelSet:
    """Return ``taxels`` with the positions of their ids in ``layout``; NaN, and a finding, for other taxels.

    Raises:
        SkinError: The layout has none of the taxels.
    """
    ids = taxels.stated_ids
    place = np.minimum(np.searchsorted(layout.numbers, ids), len(layout.numbers) - 1)
    shown = layout.numbers[place] == ids
    if not shown.any():
        raise SkinError(
            "the layout shows none of these taxels",
            place=layout.name,
            value=f"modules {sorted(m.number for m in layout.modules)}",
            remedy=f"Choose the layout of the same patch as {taxels.name}",
        )
    points = np.where(shown[:, None], layout.points[place], np.nan)
    findings = list(layout.findings)
    add_finding(findings, "not-on-layout", layout.name, "the taxel has no place on the map", int((~shown).sum()))
    extra = int((layout.felt & ~np.isin(layout.numbers, ids)).sum())
    action = "the map has a pad without a taxel on the body"
    add_finding(findings, "layout-without-taxel", layout.name, action, extra)
    modules, channels = np.divmod(ids, ROWS_PER_MODULE)
    return replace(taxels, points=points, ids=ids, modules=modules, channels=channels).with_findings(*findings)


def _module(kind: SensorKind, words: Sequence[str], line: int) -> LayoutModule:
    def refuse(problem: str) -> SkinError:
        remedy = f"Write {kind.name} {' '.join(_NUMBERS[:_FEWEST])} [mirror [layoutNum]]"
        return SkinError(problem, place=f"line {line}", value=" ".join(words), remedy=remedy)

    try:
        values = [float(word) for word in words]
    except ValueError as error:
        raise refuse("a module must be numbers") from error
    if not _FEWEST <= len(values) <= len(_NUMBERS):
        raise refuse(f"a module must be {_FEWEST} to {len(_NUMBERS)} numbers")
    if not np.isfinite(values).all():
        raise refuse("a number is not finite")
    number, x, y, degrees, gain = values[:_FEWEST]
    if not (0 <= number < MAX_ID and number.is_integer()):
        raise refuse(f"a module's number must be whole, from 0 to {MAX_ID - 1}")
    if max(abs(x), abs(y)) * _MILLI > MAX_COORDINATE / 2 or abs(degrees) > 1e6:
        raise refuse("a module's position or rotation is implausibly large; the unit is the millimetre")
    mirror = values[_FEWEST] if len(values) > _FEWEST else 0.0
    if mirror not in (0, 1):
        raise refuse("mirror must be 0 or 1")
    # Other values of layoutNum mean 0, as in the viewer.
    backwards = len(values) == len(_NUMBERS) and values[-1] == 1
    angle = float(np.deg2rad(degrees))
    return LayoutModule(int(number), x * _MILLI, y * _MILLI, angle, mirror == 1, gain, kind, backwards)


def _first_of_each_number(
    modules: Sequence[LayoutModule], where: str, findings: list[Finding]
) -> tuple[LayoutModule, ...]:
    """Return the first module of each number, as the viewer does."""
    first = dict[int, LayoutModule]()
    same = [module == first.setdefault(module.number, module) for module in modules]
    copies = sum(same) - len(first)
    others = len(modules) - sum(same)
    add_finding(findings, "repeated-module", where, "left out: an exact copy of an earlier one", copies)
    add_finding(findings, "conflicting-module", where, "left out: an earlier one with this number differs", others)
    return tuple(first.values())
