"""Taxels as some file states them: places, and whatever else it knows of them, before they are on any surface."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, readonly, set_fields
from tactile_maps.core.errors import Finding, SkinError, add_finding
from tactile_maps.skin.model.skin import TaxelIdentity

MAX_TAXELS = 100_000
MAX_COORDINATE = 10.0
"""No taxel lies farther from its link's origin, or from its map's, than this [m]; more means another unit."""
_UNIT = 1e-6
_SPACINGS = 1e-4, 0.25
"""Neighbouring taxels are this far apart [m]; those farther apart as stated are stated in millimetres."""
_FEW = 4


@dataclass(frozen=True, eq=False)
class TaxelSet:
    """The taxels of one link, checked when made.

    Attributes:
        name: Of the patch.
        link: The link that the file names, or None.
        numbers: (n,) by which the set's taxels are told apart: as stated, unless they repeat; distinct, not negative.
        positions: (n, 3) [m], link frame.
        normals: (n, 3) outward unit normals, link frame, or None where nothing meaningful is stated.
        faces: (f, 3) triangles over the taxels, counter-clockwise from outside, or None.
        points: (n, 2) [m] a map of them that comes with the file, or None; NaN for a taxel that is not on it.
        modules: (n,) the module that carries each taxel, or None.
        ids: (n,) the hardware ids that the file states, or None; they may repeat.
        channels: (n,) the place of each taxel among those of its module, or None.
        names: (n,) what each taxel, or the sensor it is part of, is called, or None.
        areas: (n,) [m²] stated of each taxel's own pad, above zero, or None.
        findings: What was noticed and left out on the way in.

    Raises:
        SkinError: Counts disagree, a number is not finite or absurd, or an index does not exist.
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
    areas: FloatArray | None = None
    findings: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        self._keep("positions", 3, np.float64)
        if not 1 <= len(self.positions) <= MAX_TAXELS:
            raise SkinError("there must be 1 to 100,000 taxels", value=len(self.positions))
        for field, columns in (("numbers", 1), ("modules", 1), ("ids", 1), ("channels", 1), ("faces", 3)):
            self._keep(field, columns, np.int64)
        for field, columns in (("normals", 3), ("points", 2), ("areas", 1)):
            self._keep(field, columns, np.float64)
        self._check()

    def __len__(self) -> int:
        return len(self.positions)

    @cached_property
    def mapped(self) -> BoolArray:
        """(n,) which taxels the map that comes with the file shows."""
        return np.zeros(len(self), dtype=bool) if self.points is None else np.isfinite(self.points[:, 0])

    @cached_property
    def identity(self) -> TaxelIdentity:
        """Ids, modules, channels and names, as far as they are stated."""
        return TaxelIdentity(self.ids, self.modules, self.channels, self.names)

    @property
    def stated_ids(self) -> IntArray:
        """(n,) the hardware ids, or else the numbers: what formats write that have one number a taxel."""
        return self.numbers if self.ids is None else self.ids

    def select(self, which: BoolArray) -> TaxelSet:
        """Only the taxels where ``which`` (n,) is true; a face stays where all its corners do."""
        keep = np.flatnonzero(which)
        place = np.full(len(self), -1)
        place[keep] = np.arange(len(keep))
        faces = None if self.faces is None else place[self.faces][(place[self.faces] >= 0).all(axis=1)]
        return replace(
            self,
            numbers=self.numbers[keep],
            positions=self.positions[keep],
            normals=None if self.normals is None else self.normals[keep],
            faces=faces,
            points=None if self.points is None else self.points[keep],
            modules=None if self.modules is None else self.modules[keep],
            ids=None if self.ids is None else self.ids[keep],
            channels=None if self.channels is None else self.channels[keep],
            names=None if self.names is None else tuple(self.names[row] for row in keep.tolist()),
            areas=None if self.areas is None else self.areas[keep],
        )

    def with_findings(self, *findings: Finding) -> TaxelSet:
        """The same taxels with more findings."""
        return replace(self, findings=(*self.findings, *findings))

    def _keep(self, field: str, columns: int, dtype: type) -> None:
        """Make the array our own, and refuse one of another shape."""
        values = getattr(self, field)
        if values is None:
            return
        own = readonly(values, dtype)
        rows = len(own) if field in ("positions", "faces") else len(self.positions)
        if own.shape != ((rows,) if columns == 1 else (rows, columns)):
            raise SkinError("the numbers of rows or columns do not fit", place=field, value=own.shape)
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
            raise SkinError("the numbers of rows or columns do not fit", place="names", value=len(self.names))
        TaxelIdentity(self.ids, self.modules, self.channels, self.names)  # refuses what is out of range
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
    """Numbers that tell rows apart: ``numbers`` (n,), or the rows' own where one comes twice, as with two boards."""
    stated = np.asarray(numbers, dtype=np.int64)
    twice = int(_is_duplicate(stated).sum())
    action = "ids are duplicated: kept as stated, the taxels are told apart by their order"
    add_finding(findings, "duplicate-number", where, action, twice)
    return np.arange(len(stated)) if twice else stated


def unit_normals(normals: FloatArray, where: str, findings: list[Finding]) -> FloatArray | None:
    """``normals`` (n, 3) at length one; None, and a finding, where one has no direction at all."""
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


def length_unit(places: FloatArray, where: str, findings: list[Finding]) -> float:
    """Metres in the unit of ``places`` (n, 2 or 3) that state none: 1, or 0.001 where metres cannot be meant.

    Millimetres are taken, and told, where metres would put a place beyond ``MAX_COORDINATE`` or the typical neighbours
    of four or more taxels over 0.25 m apart, and millimetres bring both to what skins have.
    """
    distinct = np.unique(places, axis=0)
    if len(distinct) < 2 or not np.isfinite(distinct).all():
        return 1.0
    spacing = float(np.median(cKDTree(distinct).query(distinct, k=2)[0][:, 1]))
    too_far = np.abs(distinct).max() > MAX_COORDINATE
    too_sparse = len(distinct) >= _FEW and spacing > _SPACINGS[1]
    plausible = spacing * 1e-3 >= _SPACINGS[0] and np.abs(distinct).max() * 1e-3 <= MAX_COORDINATE
    if not ((too_far or too_sparse) and plausible):
        return 1.0
    action = f"taken as millimetres: in metres, neighbouring taxels would be {spacing:.3g} m apart"
    findings.append(Finding("guessed-unit", where, action, len(places)))
    return 1e-3


def _is_duplicate(numbers: IntArray) -> BoolArray:
    """(n,) whether a number came before."""
    again = np.ones(len(numbers), dtype=bool)
    again[np.unique(numbers, return_index=True)[1]] = False
    return again


def is_number(word: str) -> bool:
    """Whether a word of a text file is a number with a decimal point."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def line_error(problem: str, path: Path, line: int, value: object) -> SkinError:
    """What is wrong with a line of a text file."""
    return SkinError(problem, file=path, place=f"line {line}", value=value, remedy="Correct the line, or leave it out")
