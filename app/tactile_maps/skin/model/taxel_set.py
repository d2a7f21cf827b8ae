"""Taxels as stated in a file, before they are on a surface: positions and optional properties."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, readonly, set_fields
from tactile_maps.core.errors import Finding, SkinError, add_finding
from tactile_maps.geometry.surface.points import nearest_others
from tactile_maps.skin.model.skin import IDENTITY_FIELDS, TaxelIdentity
from tactile_maps.skin.model.taxel_axes import checked_axes, checked_tangents

MAX_TAXELS = 100_000
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6}
"""Units of length that files state, in metres."""
MAX_COORDINATE = 10.0
"""Largest coordinate of a taxel on its link or map [m]; larger ones are in another unit."""
_UNIT = 1e-6
_SPACINGS = 1e-4, 0.25
"""Range of distances between adjacent taxels [m]; larger ones are in millimetres."""
_FEW = 4


@dataclass(frozen=True, eq=False)
class TaxelSet:
    """Taxels of one link, checked on construction.

    Attributes:
        name: Name of the patch.
        link: Name of the link in the file, or None.
        numbers: (n,) distinct numbers of the taxels, not negative: as stated, or their order if those are repeated.
        positions: (n, 3) [m], link frame.
        normals: (n, 3) outward unit normals, link frame, or None if none are stated or they are dummies.
        faces: (f, 3) triangles over the taxels, counter-clockwise from outside, or None.
        points: (n, 2) positions on a map in the same file [m], or None; NaN for a taxel that is not on it.
        modules: (n,) module of each taxel, or None.
        ids: (n,) hardware ids as stated, or None; they may be repeated.
        channels: (n,) channel of each taxel in its module, or None.
        names: (n,) name of each taxel or of its sensor, or None.
        aliases: (k, 2) further ids at the place of a taxel, and its row, or None.
        stream: Number of values in the vendor's stream without ids, in which value k is that of id k, or None.
        areas: (n,) stated area of the pad of each taxel [m²], above zero, or None.
        axes: (n,) number of axes of each taxel, 1 or 3; None if all have one.
        tangents: (n, 3) unit first tangents t1 of the taxels, link frame, perpendicular to the normals if there are
            any; NaN where not stated; None if none is.
        findings: Defects that were found while reading.

    Raises:
        SkinError: Counts disagree, a number is not finite or implausible, or an index does not exist.
    """

    name: str
    link: str | None
    numbers: IntArray
    positions: FloatArray
    normals: FloatArray | None = None
    faces: IntArray | None = None
    points: FloatArray | None = None
    modules: IntArray | None = None
    ids: IntArray | None = None
    channels: IntArray | None = None
    names: tuple[str, ...] | None = None
    aliases: IntArray | None = None
    stream: int | None = None
    areas: FloatArray | None = None
    axes: IntArray | None = None
    tangents: FloatArray | None = None
    findings: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        self._keep("positions", 3, np.float64)
        if not 1 <= len(self.positions) <= MAX_TAXELS:
            raise SkinError("there must be 1 to 100,000 taxels", value=len(self.positions))
        for field in ("numbers", "axes", *IDENTITY_FIELDS):
            self._keep(field, 1, np.int64)
        self._keep("faces", 3, np.int64)
        self._keep("aliases", 2, np.int64)
        for field, columns in (("normals", 3), ("points", 2), ("areas", 1), ("tangents", 3)):
            self._keep(field, columns, np.float64)
        self._check()

    def __len__(self) -> int:
        return len(self.positions)

    @cached_property
    def mapped(self) -> BoolArray:
        """(n,) whether each taxel is on the map in the file."""
        return np.zeros(len(self), dtype=bool) if self.points is None else np.isfinite(self.points[:, 0])

    @cached_property
    def identity(self) -> TaxelIdentity:
        """Stated ids, modules, channels and names."""
        return TaxelIdentity(self.ids, self.modules, self.channels, self.names, self.aliases, self.stream)

    @property
    def stated_ids(self) -> IntArray:
        """(n,) the hardware ids, or the numbers without ids: for formats with one number per taxel."""
        return self.numbers if self.ids is None else self.ids

    def select(self, which: BoolArray) -> TaxelSet:
        """Return the taxels where ``which`` (n,) is true, and the faces whose corners are all among them."""
        keep = np.flatnonzero(which)
        place = np.full(len(self), -1)
        place[keep] = np.arange(len(keep))
        arrays = ("numbers", "positions", "normals", "points", "areas", "axes", "tangents", *IDENTITY_FIELDS)
        chosen: dict[str, Any] = {field: array[keep] for field in arrays if (array := getattr(self, field)) is not None}
        return replace(
            self,
            **chosen,
            aliases=self.identity.select(keep).aliases,
            faces=None if self.faces is None else place[self.faces][(place[self.faces] >= 0).all(axis=1)],
            names=None if self.names is None else tuple(self.names[row] for row in keep.tolist()),
        )

    def with_findings(self, *findings: Finding) -> TaxelSet:
        """Return the same taxels with more findings."""
        return replace(self, findings=(*self.findings, *findings))

    def _keep(self, field: str, columns: int, dtype: type) -> None:
        """Copy the array and check its shape."""
        values = getattr(self, field)
        if values is None:
            return
        own = readonly(values, dtype)
        rows = len(own) if field in ("positions", "faces", "aliases") else len(self.positions)
        if own.shape != ((rows,) if columns == 1 else (rows, columns)):
            raise SkinError("the number of rows or columns is wrong", place=field, value=own.shape)
        set_fields(self, **{field: own})

    def _check(self) -> None:
        positions = self.positions
        points = self.points
        self._refuse("positions", "a position is not a finite number", ~np.isfinite(positions).all(axis=1))
        far = (np.abs(positions) > MAX_COORDINATE).any(axis=1)
        self._refuse(
            "positions", f"a taxel is more than {MAX_COORDINATE:g} m from its link; positions are in metres", far
        )
        self._refuse("numbers", "a taxel's number is negative", self.numbers < 0)
        self._refuse("numbers", "two taxels have the same number", _is_duplicate(self.numbers))
        if self.normals is not None:
            away = np.abs(np.linalg.norm(self.normals, axis=1) - 1)
            self._refuse("normals", "a normal is not of length one", ~(away < _UNIT))
        if self.areas is not None:
            self._refuse("areas", "an area is not above zero", ~((self.areas > 0) & np.isfinite(self.areas)))
        if self.names is not None and len(self.names) != len(self):
            raise SkinError("the number of rows or columns is wrong", place="names", value=len(self.names))
        axes = checked_axes(self.axes, len(self))
        set_fields(self, axes=axes, tangents=checked_tangents(self.tangents, self.normals, len(self)))
        _ = self.identity  # raises if a number is out of range
        if points is not None:
            off = ~(np.isnan(points).all(axis=1) | (np.abs(points) <= MAX_COORDINATE).all(axis=1))
            self._refuse("points", f"a map point is not within {MAX_COORDINATE:g} m; map points are in metres", off)
        if self.faces is not None:
            bad = ((self.faces < 0) | (self.faces >= len(self))).any(axis=1)
            self._refuse("faces", "a face names a taxel that does not exist", bad)

    def _refuse(self, field: str, problem: str, bad: ArrayLike) -> None:
        if np.any(bad):
            row = int(np.argmax(bad))
            raise SkinError(problem, place=f"{field}, row {row}", value=np.asarray(getattr(self, field))[row].tolist())


def distinct_numbers(numbers: ArrayLike, where: str, findings: list[Finding]) -> IntArray:
    """Return distinct numbers of rows: ``numbers`` (n,), or 0 to n - 1 if any is repeated, as with several boards."""
    stated = np.asarray(numbers, dtype=np.int64)
    repeated = int(_is_duplicate(stated).sum())
    action = "ids are duplicated: kept as stated, the taxels are numbered by their order"
    add_finding(findings, "duplicate-number", where, action, repeated)
    return np.arange(len(stated)) if repeated else stated


def further_ids(aliases: IntArray, count: int) -> list[list[int]]:
    """Return the further ids of each of ``count`` taxels, from ``aliases`` (k, 2) of ids and rows."""
    found: list[list[int]] = [[] for _ in range(count)]
    for number, row in aliases.tolist():
        found[row].append(number)
    return found


def unit_normals(normals: FloatArray, where: str, findings: list[Finding]) -> FloatArray | None:
    """Return ``normals`` (n, 3) scaled to length one; None, and a finding, if one of them has no direction."""
    size = np.abs(normals).max(axis=1, keepdims=True)
    lost = int((~((size > 0) & np.isfinite(size))).sum())
    add_finding(findings, "dummy-normals", where, "the normals are not used: some have no direction", lost)
    if lost:
        return None
    scaled = normals / size  # so that squares neither overflow nor vanish
    length = np.linalg.norm(scaled, axis=1, keepdims=True)
    add_finding(
        findings, "normals-not-unit", where, "scaled to length one", int((np.abs(size * length - 1) > 1e-2).sum())
    )
    return scaled / length


def stated_areas(areas: FloatArray, where: str, findings: list[Finding]) -> FloatArray | None:
    """Return ``areas`` (n,) [m²]; None, and a finding, if the area of a taxel is missing or not above zero."""
    lacking = int((~(areas > 0)).sum())
    add_finding(findings, "area-unknown", where, "the areas are not used: not above zero for every taxel", lacking)
    return None if lacking else areas


def length_unit(places: FloatArray, where: str, findings: list[Finding]) -> float:
    """Return the unit of ``places`` (n, 2 or 3) without a stated one [m]: 1, or 0.001 if metres are implausible.

    Millimetres are assumed, with a finding, if in metres a place were beyond ``MAX_COORDINATE`` or the median distance
    of four or more taxels to their neighbours were above 0.25 m, and both are plausible in millimetres.
    """
    distinct = np.unique(places, axis=0)
    if len(distinct) < 2 or not np.isfinite(distinct).all():
        return 1.0
    spacing = float(np.median(nearest_others(distinct, 1)[0]))
    too_far = np.abs(distinct).max() > MAX_COORDINATE
    too_sparse = len(distinct) >= _FEW and spacing > _SPACINGS[1]
    plausible = spacing * 1e-3 >= _SPACINGS[0] and np.abs(distinct).max() * 1e-3 <= MAX_COORDINATE
    if not ((too_far or too_sparse) and plausible):
        return 1.0
    action = f"taken as millimetres: in metres, neighbouring taxels would be {spacing:.3g} m apart"
    findings.append(Finding("guessed-unit", where, action, len(places)))
    return 1e-3


def _is_duplicate(numbers: IntArray) -> BoolArray:
    """Return (n,) whether each number is a repetition."""
    again = np.ones(len(numbers), dtype=bool)
    again[np.unique(numbers, return_index=True)[1]] = False
    return again


def is_number(word: str) -> bool:
    """Return whether a word of a text file is a number with a decimal point."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def line_error(problem: str, line: int, value: object) -> SkinError:
    """Return the error about a line of a text file."""
    return SkinError(problem, place=f"line {line}", value=value, remedy="Correct the line, or leave it out")
