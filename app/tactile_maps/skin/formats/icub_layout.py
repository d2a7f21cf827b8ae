"""iCub layout files: the hand-drawn map of a patch, as the iCub skin viewer reads it.

The format is that of iCubSkinGui (robotology/icub-main, app/skinGui/conf/skinGui): named settings, then under
``[SENSORS]`` one line ``type id x y orientation gain [mirror [layoutNum]]`` a module, in units of about a
millimetre and in degrees. A module is mirrored, then turned, then moved. ``layoutNum`` 1 counts its pads backwards.
Taxels are counted through the modules in the order of their ids; an id that no module has counts as twelve. So taxel
``12 id + pad`` is pad ``pad``, but behind a palm, whose 48 pads are those of four boards, the count is ahead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, readonly
from tactile_maps.core.errors import Finding, SkinError, add_finding
from tactile_maps.core.files import read_bounded_text, write_lines
from tactile_maps.skin.formats.icub_positions import ROWS_PER_MODULE
from tactile_maps.skin.formats.icub_sensor_kinds import KINDS, TRIANGLE, SensorKind
from tactile_maps.skin.model.taxel_set import MAX_COORDINATE, TaxelSet

MAX_BYTES = 2**20
MAX_ID = 8192
_MILLI = 1e-3
_NUMBERS = ("id", "x", "y", "orientation", "gain", "mirror", "layoutNum")
_FEWEST = 5


@dataclass(frozen=True)
class LayoutModule:
    """One module on the hand-drawn map.

    Attributes:
        number: Which module of the patch.
        x: Of its middle [m].
        y: Of its middle [m].
        angle: Counter-clockwise [rad].
        mirrored: Whether x is negated before it is turned.
        gain: What the viewer multiplies its readings by.
        kind: Which decides where its pads lie.
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
        """(n, 2) where its channels lie on the map [m]; NaN for one without a pad."""
        cosine = np.cos(self.angle)
        sine = np.sin(self.angle)
        pads = self.kind.pads * [-1.0 if self.mirrored and self.kind.mirrors else 1.0, 1.0]
        pads = pads[::-1] if self.backwards else pads
        return pads @ np.array([[cosine, sine], [-sine, cosine]]) + [self.x, self.y]


@dataclass(frozen=True)
class IcubLayout:
    """A hand-drawn map of a patch.

    Attributes:
        name: Of the file, without its ending.
        modules: In the file's order, each number once.
        settings: The named values above the modules, as the file states them.
        findings: What was noticed and left out.
    """

    name: str
    modules: tuple[LayoutModule, ...]
    settings: tuple[tuple[str, str], ...] = ()
    findings: tuple[Finding, ...] = field(default=(), compare=False)

    @cached_property
    def starts(self) -> dict[int, int]:
        """The first taxel of each module, by its number."""
        starts = {}
        ahead = 0
        for module in self._in_order:
            starts[module.number] = ROWS_PER_MODULE * module.number + ahead
            ahead += len(module.kind.pads) - ROWS_PER_MODULE
        return starts

    @cached_property
    def numbers(self) -> IntArray:
        """(k,) the taxels that the map shows, thermal pads included, in increasing order."""
        channels = [self.starts[m.number] + np.arange(len(m.kind.pads)) for m in self._in_order]
        return readonly(np.concatenate(channels)[self._placed], np.int64)

    @cached_property
    def points(self) -> FloatArray:
        """(k, 2) where they lie [m]."""
        return readonly(np.concatenate([m.points for m in self._in_order])[self._placed])

    @cached_property
    def felt(self) -> BoolArray:
        """(k,) which of them feel touch."""
        felt = [m.kind.felt[::-1] if m.backwards else m.kind.felt for m in self._in_order]
        return readonly(np.concatenate(felt)[self._placed], bool)

    @property
    def _in_order(self) -> list[LayoutModule]:
        return sorted(self.modules, key=lambda module: module.number)

    @property
    def _placed(self) -> BoolArray:
        """Of all channels, those that have a pad."""
        return np.isfinite(np.concatenate([m.points for m in self._in_order])[:, 0])


def read_icub_layout(path: str | Path) -> IcubLayout:
    """The modules in the layout file at ``path``.

    Modules of kinds that the viewer does not know are left out and counted, and so is every module that comes again.

    Raises:
        SkinError: It cannot be read, a line is not what the format allows, or no module is of a known kind.
    """
    path = Path(path)
    settings: list[tuple[str, str]] = []
    modules: list[LayoutModule] = []
    unknown: list[str] = []
    inside = False
    for number, line in enumerate(read_bounded_text(path, most=MAX_BYTES, error=SkinError).splitlines(), start=1):
        words = line.split()
        if not words or words[0].startswith(("#", "//")):
            continue
        if words[0].startswith("["):
            inside = words[0].upper() == "[SENSORS]"
        elif not inside:
            settings.append((words[0], " ".join(words[1:])))
        elif words[0] in KINDS:
            modules.append(_module(KINDS[words[0]], words[1:], path, number))
        else:
            unknown.append(words[0])
    if not modules:
        value = ", ".join(sorted(set(unknown))) or None
        remedy = f"Modules of these kinds can be read: {', '.join(KINDS)}"
        raise SkinError("the file has no module of a known kind", file=path, value=value, remedy=remedy)
    findings = [
        Finding("unknown-sensor-kind", path.name, f"left out: where the pads of {kind} lie is not known", count)
        for kind, count in sorted((kind, unknown.count(kind)) for kind in set(unknown))
    ]
    return IcubLayout(path.stem, _first_of_each_number(modules, path.name, findings), tuple(settings), tuple(findings))


def write_icub_layout(layout: IcubLayout, path: str | Path) -> None:
    """Write ``layout`` as the viewer reads it.

    Raises:
        SkinError: The file cannot be written.
    """
    lines = [" ".join(setting) for setting in layout.settings]
    lines += ["", "[SENSORS]", "# kind number x y orientation gain mirror layoutNum"]
    lines += [
        f"{m.kind.name} {m.number} {m.x / _MILLI:.10g} {m.y / _MILLI:.10g} {np.rad2deg(m.angle):.10g} {m.gain:.10g} "
        f"{int(m.mirrored)} {int(m.backwards)}"
        for m in layout.modules
    ]
    write_lines(Path(path), lines, error=SkinError)


def apply_layout(taxels: TaxelSet, layout: IcubLayout) -> TaxelSet:
    """``taxels`` with the points that ``layout`` gives their ids; NaN, and a finding, where it gives none.

    Raises:
        SkinError: They have no taxel in common.
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
    add_finding(
        findings, "layout-without-taxel", layout.name, "the map shows a pad that has no taxel on the body", extra
    )
    modules, channels = np.divmod(ids, ROWS_PER_MODULE)
    return replace(taxels, points=points, ids=ids, modules=modules, channels=channels).with_findings(*findings)


def _module(kind: SensorKind, words: Sequence[str], path: Path, line: int) -> LayoutModule:
    def refuse(problem: str) -> SkinError:
        remedy = f"Write {kind.name} {' '.join(_NUMBERS[:_FEWEST])} [mirror [layoutNum]]"
        return SkinError(problem, file=path, place=f"line {line}", value=" ".join(words), remedy=remedy)

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
    # A count other than these two is read as the first, as by the viewer.
    backwards = len(values) == len(_NUMBERS) and values[-1] == 1
    angle = float(np.deg2rad(degrees))
    return LayoutModule(int(number), x * _MILLI, y * _MILLI, angle, mirror == 1, gain, kind, backwards)


def _first_of_each_number(
    modules: Sequence[LayoutModule], where: str, findings: list[Finding]
) -> tuple[LayoutModule, ...]:
    """The first module of each number, as the viewer does it."""
    first: dict[int, LayoutModule] = {}
    copies = 0
    others = 0
    for module in modules:
        if first.setdefault(module.number, module) is not module:
            same = module == first[module.number]
            copies = copies + same
            others = others + (not same)
    add_finding(findings, "repeated-module", where, "left out: an exact copy of one before", copies)
    add_finding(findings, "conflicting-module", where, "left out: the same number is placed elsewhere before", others)
    return tuple(first.values())
