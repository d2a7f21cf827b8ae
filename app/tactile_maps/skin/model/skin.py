"""Skin of a robot: patches on links, the taxels of each patch, and the numbers of all taxels.

A taxel is on the surface of its patch and has an area, which is carried by quadrature points: pressure is evaluated
there and summed by taxel.

In the program a taxel has a running number, which depends on the file, the fit and the order of the patches. Readings
refer to its identity in the electronics of the robot: id, module, and channel on the board of the module. The identity
is passed on unchanged. Ids may be repeated by several boards.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray, readonly, set_fields
from tactile_maps.core.errors import Finding, SkinError
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tactile_maps.skin.model.taxel_axes import checked_axes, checked_tangents

LARGEST_NUMBER = 2**31 - 1
"""Largest id, module or channel."""
IDENTITY_FIELDS = ("ids", "modules", "channels")
"""Names of the numbers of an identity."""
LONGEST_NAME = 200


@dataclass(frozen=True)
class TaxelName:
    """Identity of one taxel; None for unknown parts."""

    id: int | None = None
    module: int | None = None
    channel: int | None = None
    name: str | None = None

    def __str__(self) -> str:
        """Return for example ``thumb_touch, id 87012, module 14, channel 3``, without unknown parts."""
        parts = (("", self.name), ("id ", self.id), ("module ", self.module), ("channel ", self.channel))
        return ", ".join(f"{word}{part}" for word, part in parts if part is not None)


@dataclass(frozen=True, eq=False)
class TaxelIdentity(ArrayFields, aliases=2):
    """Identities of n taxels; an unknown array is None.

    Attributes:
        ids: (n,) hardware ids, as stated; they may be repeated.
        modules: (n,) module, or board, of each taxel.
        channels: (n,) channel of each taxel in its module.
        names: (n,) name of each taxel or of its sensor; they may be repeated.
        aliases: (k, 2) further ids at the place of a taxel, and the row of that taxel.
        stream: Number of values in the vendor's stream without ids, in which value k is that of id k.

    Raises:
        SkinError: An array does not have one axis, lengths differ, a number is not in the range 0 to 2³¹ - 1, or a name
            has more than 200 characters.
    """

    ids: IntArray | None = None
    modules: IntArray | None = None
    channels: IntArray | None = None
    names: tuple[str, ...] | None = None
    aliases: IntArray | None = None
    stream: int | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        count: int | None = None
        for field in IDENTITY_FIELDS:
            values: IntArray | None = getattr(self, field)
            if values is None:
                continue
            if values.ndim != 1 or len(values) != (len(values) if count is None else count):
                raise SkinError("the number of rows or columns is wrong", place=field, value=values.shape)
            count = len(values)
            bad = (values < 0) | (values > LARGEST_NUMBER)
            if bad.any():
                row = int(bad.argmax())
                problem = "a number is negative" if values[row] < 0 else f"a number is above {LARGEST_NUMBER}"
                raise SkinError(problem, place=f"{field}, row {row}", value=int(values[row]))
        if self.names is not None:
            if count is not None and len(self.names) != count:
                raise SkinError("the number of rows or columns is wrong", place="names", value=len(self.names))
            for row, name in enumerate(self.names):
                if len(name) > LONGEST_NAME:
                    problem = f"a name is longer than {LONGEST_NAME} characters"
                    raise SkinError(problem, place=f"names, row {row}", value=f"{name[:40]}...")
        if self.aliases is not None:
            invalid = (self.aliases < 0) | (self.aliases > [LARGEST_NUMBER, len(self) - 1])
            if invalid.any():
                row = int(invalid.any(axis=1).argmax())
                raise SkinError(
                    "invalid alias of a taxel", place=f"aliases, row {row}", value=self.aliases[row].tolist()
                )
        if self.stream is not None and not 0 < self.stream <= LARGEST_NUMBER:
            raise SkinError("invalid number of values in a stream", place="stream", value=self.stream)

    def __len__(self) -> int:
        """Return the number of taxels, 0 for an unknown identity."""
        return next((len(values) for values in (*self._arrays(), self.names) if values is not None), 0)

    @property
    def known(self) -> bool:
        """Whether any part is known."""
        return any(values is not None for values in (*self._arrays(), self.names))

    def select(self, rows: IntArray) -> TaxelIdentity:
        """Return the identities of the taxels ``rows`` (k,), in that order."""
        names = None if self.names is None else tuple(self.names[row] for row in np.asarray(rows).tolist())
        ids, modules, channels = (None if values is None else values[rows] for values in self._arrays())
        return TaxelIdentity(ids, modules, channels, names, self._aliases_of(rows), self.stream)

    def merged(self, first: IntArray, place: IntArray) -> TaxelIdentity:
        """Return the identities of places: the ids of taxels that share a place with another become its aliases.

        Args:
            first: (k,) taxel that represents each place.
            place: (n,) place of each taxel.
        """
        kept = self.select(first)
        others = np.setdiff1d(np.arange(len(place)), first)
        parts = [] if self.ids is None else [np.column_stack([self.ids[others], place[others]])]
        if self.aliases is not None:
            parts.append(np.column_stack([self.aliases[:, 0], place[self.aliases[:, 1]]]))
        aliases = np.concatenate(parts) if parts else np.zeros((0, 2), dtype=np.int64)
        return replace(kept, aliases=aliases if len(aliases) else None)

    def name(self, row: int) -> TaxelName:
        """Return the identity of one taxel."""
        number, module, channel = (None if values is None else int(values[row]) for values in self._arrays())
        return TaxelName(number, module, channel, None if self.names is None else self.names[row])

    def _aliases_of(self, rows: IntArray) -> IntArray | None:
        """Return the aliases of the taxels ``rows`` (k,), with their new rows."""
        if self.aliases is None:
            return None
        place = np.full(len(self), -1)
        place[rows] = np.arange(len(rows))
        found = np.column_stack([self.aliases[:, 0], place[self.aliases[:, 1]]])
        found = found[found[:, 1] >= 0]
        return found if len(found) else None

    def _arrays(self) -> tuple[IntArray | None, ...]:
        return self.ids, self.modules, self.channels


NO_IDENTITY = TaxelIdentity()


def join_identities(parts: Sequence[TaxelIdentity]) -> TaxelIdentity:
    """Return the identities of the taxels of all ``parts`` in order; an array that a part does not have is None."""
    columns = ([getattr(part, field) for part in parts] for field in IDENTITY_FIELDS)
    ids, modules, channels = (
        np.concatenate(arrays) if arrays and all(a is not None for a in arrays) else None for arrays in columns
    )
    named = [part.names for part in parts if part.names is not None]
    names = tuple(chain(*named)) if named and len(named) == len(parts) else None
    starts = np.cumsum([0, *map(len, parts)])
    further = [
        part.aliases + [0, start] for part, start in zip(parts, starts, strict=False) if part.aliases is not None
    ]
    streams = {part.stream for part in parts}
    return TaxelIdentity(
        ids,
        modules,
        channels,
        names,
        np.concatenate(further) if further and ids is not None else None,
        streams.pop() if len(streams) == 1 else None,
    )


def identity_summary(identity: TaxelIdentity) -> dict[str, dict[str, int]]:
    """Return for each known array the number of different values, the smallest, the largest, and of repeated ids; for
    names and aliases the number of different ones.
    """
    found = {}
    for field in IDENTITY_FIELDS:
        values: IntArray | None = getattr(identity, field)
        if values is not None and len(values):
            counts = np.unique(values, return_counts=True)[1]
            repeated = int((counts > 1).sum()) if field == "ids" else 0
            found[field] = {
                "different": len(counts),
                "first": int(values.min()),
                "last": int(values.max()),
                "repeated": repeated,
            }
    if identity.aliases is not None:
        found["aliases"] = {"different": len(np.unique(identity.aliases, axis=0))}
    if identity.names:
        found["names"] = {"different": len(set(identity.names))}
    return found


def identity_text(summary: Mapping[str, Mapping[str, int]]) -> str:
    """Return an ``identity_summary`` as text, for example ``ids 86999 to 87438 (440), modules 0 to 63 (44)``."""
    parts = []
    for field, found in summary.items():
        if field in ("names", "aliases"):
            parts.append(f"{found['different']} {field}")
            continue
        again = f", {found['repeated']} repeated" if found["repeated"] else ""
        parts.append(f"{field} {found['first']} to {found['last']} ({found['different']}{again})")
    return ", ".join(parts)


def number_ranges(numbers: Sequence[int] | IntArray, *, most: int = 8) -> str:
    """Return whole numbers as ranges, for example ``0-3, 12, 20-23 and 9 more``.

    Args:
        numbers: Numbers in any order; repetitions do not count.
        most: Largest number of ranges; of further numbers only the count is stated.
    """
    values = np.unique(np.asarray(numbers, dtype=np.int64))
    runs = np.split(values, np.flatnonzero(np.diff(values) > 1) + 1) if len(values) else []
    texts = [f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]) for run in runs[:most]]
    left = sum(map(len, runs[most:]))
    return ", ".join(texts) + (f" and {left} more" if left else "")


@dataclass(frozen=True, eq=False)
class Quadrature(ArrayFields):
    """Evenly spread points with the area of the patch, at which contact pressure is evaluated and summed by taxel.

    There are ten to thirty per taxel: fewer miss contacts smaller than the pitch, more do not increase the accuracy.

    Attributes:
        positions: (q, 3) [m], link frame.
        normals: (q, 3) outward unit normals, link frame.
        areas: (q,) [m²]; they sum to the area of the taxels.
        taxel: (q,) index in the patch of the taxel of each point.
    """

    positions: FloatArray
    normals: FloatArray
    areas: FloatArray
    taxel: IntArray


@dataclass(frozen=True, eq=False)
class Taxels(ArrayFields):
    """Taxels of one patch.

    Attributes:
        positions: (n, 3) [m], link frame, on the surface of the patch.
        normals: (n, 3) outward unit normals.
        faces: (n,) face of the surface that contains each taxel.
        weights: (n, 3) barycentric weights in that face.
        areas: (n,) [m²], each > 0: the sum of the areas of its quadrature points.
        neighbours: (e, 2) pairs of taxels whose cells touch on the body (seams do not separate them), i < j.
        quadrature: Points at which pressure is evaluated.
        identity: Identity in the electronics of the robot, as far as a file states it.
        axes: (n,) number of axes of each taxel: 1 (pressure) or 3 (pressure and shear). None if all have one.
        tangents: (n, 3) first tangent t1 of the frame of each taxel, link frame: unit vectors perpendicular to the
            normals, NaN for a taxel whose tangent is not stated. None if none is. The frame is (t1, t2, n) with
            t2 = n x t1. Taxels with one axis may have a tangent, too.

    Raises:
        SkinError: The identity has another number of taxels, a number of axes is neither 1 nor 3, or a tangent is not
            a unit vector perpendicular to its normal.
    """

    positions: FloatArray
    normals: FloatArray
    faces: IntArray
    weights: FloatArray
    areas: FloatArray
    neighbours: IntArray
    quadrature: Quadrature
    identity: TaxelIdentity = NO_IDENTITY
    axes: IntArray | None = None
    tangents: FloatArray | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.identity.known and len(self.identity) != len(self.positions):
            found = f"{len(self.identity)} of {len(self.positions)} taxels"
            raise SkinError("the identity has another number of taxels", place="identity", value=found)
        axes = checked_axes(self.axes, len(self))
        set_fields(self, axes=axes, tangents=checked_tangents(self.tangents, self.normals, len(self)))

    def __len__(self) -> int:
        return len(self.positions)


def taxels_with_axes(taxels: Taxels, axes: int) -> Taxels:
    """Return the taxels with the same number of ``axes`` each."""
    return taxels if axes == 1 else replace(taxels, axes=np.full(len(taxels), axes))


@dataclass(frozen=True, eq=False)
class Patch:
    """A piece of skin that covers one link.

    Attributes:
        name: Unique in the skin.
        link: Name of the link that it covers.
        surface: Outer surface without cuts, link frame; connected and manifold.
        taxels: Its taxels.
    """

    name: str
    link: str
    surface: Mesh
    taxels: Taxels


@dataclass(frozen=True, eq=False)
class BarePoints(ArrayFields):
    """Points on the surface of a skinned link that its skin leaves bare. They bear load, and no taxel reads them.

    Attributes:
        link: Name of the link.
        positions: (k, 3) [m], link frame.
        normals: (k, 3) outward unit normals, link frame.
        areas: (k,) [m²].
    """

    link: str
    positions: FloatArray
    normals: FloatArray
    areas: FloatArray


@dataclass(frozen=True, eq=False)
class Skin:
    """All patches of a robot; taxels are numbered through the patches in order.

    Attributes:
        patches: Patches in a stable order.
        findings: Defects that were found or repaired while making it.
        bare_area: Area of the requested surface without taxels [m²]: pieces too small for a taxel, places of a grid
            beyond an edge. Other surface, such as inner walls, does not count.
        bare_points: Surface of the links that bears load next to the skin, for contact models; empty unless added by
            ``bare_surface.with_bare_points``. Files do not store it.

    Example:
        >>> at = skin.taxel_point(30)
        >>> skin.link(at), skin.position(at).shape, skin.areas.shape
        ('hand', (3,), (60,))
    """

    patches: tuple[Patch, ...]
    findings: tuple[Finding, ...] = ()
    bare_area: float = 0.0
    bare_points: tuple[BarePoints, ...] = ()

    @property
    def coverage(self) -> float:
        """Share of the requested surface that has taxels, 0 to 1."""
        covered = sum(patch.surface.area for patch in self.patches)
        return covered / (covered + self.bare_area) if covered else 0.0

    @cached_property
    def first(self) -> IntArray:
        """(patches + 1,) number of each patch's first taxel; the last entry is the number of taxels."""
        return readonly(np.cumsum([0, *(len(p.taxels) for p in self.patches)]), np.int64)

    def __len__(self) -> int:
        """Return the number of taxels."""
        return int(self.first[-1])

    @cached_property
    def areas(self) -> FloatArray:
        """(n,) [m²]."""
        return readonly(np.concatenate([p.taxels.areas for p in self.patches]) if self.patches else np.zeros(0))

    @cached_property
    def links(self) -> tuple[str, ...]:
        """Names of the links with skin, in the order of their first patches."""
        return tuple(dict.fromkeys(patch.link for patch in self.patches))

    @cached_property
    def positions(self) -> FloatArray:
        """(n, 3) positions of the taxels [m], link frames."""
        return readonly(np.concatenate([np.zeros((0, 3)), *(taxels.positions for taxels in self._taxels)]))

    @cached_property
    def normals(self) -> FloatArray:
        """(n, 3) outward unit normals of the taxels, link frames."""
        return readonly(np.concatenate([np.zeros((0, 3)), *(taxels.normals for taxels in self._taxels)]))

    @cached_property
    def patch_of(self) -> IntArray:
        """(n,) patch index of each taxel."""
        return readonly(np.repeat(np.arange(len(self.patches)), np.diff(self.first)), np.int64)

    @cached_property
    def axes(self) -> IntArray:
        """(n,) number of axes of each taxel: 1 (pressure) or 3 (pressure and shear)."""
        parts = [np.ones(len(t), dtype=np.int64) if t.axes is None else t.axes for t in self._taxels]
        return readonly(np.concatenate(parts) if parts else np.zeros(0), np.int64)

    @cached_property
    def three_axis(self) -> BoolArray:
        """(n,) whether each taxel measures shear, too."""
        return readonly(self.axes == 3, np.bool_)

    @cached_property
    def tangents(self) -> FloatArray:
        """(n, 3) stated first tangents t1 of the taxels, link frames; NaN where not stated, see ``taxel_frames``."""
        parts = [np.full((len(t), 3), np.nan) if t.tangents is None else t.tangents for t in self._taxels]
        return readonly(np.concatenate(parts) if parts else np.zeros((0, 3)))

    @cached_property
    def neighbours(self) -> IntArray:
        """(e, 2) pairs of adjacent taxels, as numbers in the skin."""
        pairs = [p.taxels.neighbours + start for p, start in zip(self.patches, self.first[:-1], strict=True)]
        return readonly(np.concatenate(pairs) if pairs else np.zeros((0, 2)), np.int64)

    @cached_property
    def identity(self) -> TaxelIdentity:
        """Identities of all taxels; arrays that only some patches have are None."""
        return join_identities([patch.taxels.identity for patch in self.patches if len(patch.taxels)])

    @property
    def _taxels(self) -> Iterator[Taxels]:
        return (patch.taxels for patch in self.patches)

    def taxel_name(self, taxel: int) -> TaxelName:
        """Return the identity of taxel number ``taxel``, as far as its patch states it."""
        patch = int(self.patch_of[taxel])
        return self.patches[patch].taxels.identity.name(taxel - int(self.first[patch]))

    def taxel_text(self, taxel: int) -> str:
        """Return the name of taxel number ``taxel`` by its hardware, or its number, for messages."""
        return str(self.taxel_name(taxel)) or f"taxel {taxel}"

    def taxels_named(self, name: str) -> IntArray:
        """Return (k,) numbers of the taxels of that name in any case, such as all cells of a sensor."""
        folded = name.casefold()
        parts = zip(self.first[:-1].tolist(), self.patches, strict=True)
        names = [(start, patch.taxels.identity.names) for start, patch in parts]
        found = [start + row for start, own in names if own for row, one in enumerate(own) if one.casefold() == folded]
        return readonly(found, np.int64)

    def taxels_with_id(self, number: int, *, link: str | None = None) -> IntArray:
        """Return (k,) numbers of the taxels with a hardware id or alias; several if boards or links repeat ids.

        Args:
            number: The id.
            link: Link of the taxels; None for any.
        """
        found: list[int] = []
        for patch, start in zip(self.patches, self.first[:-1].tolist(), strict=True):
            identity = patch.taxels.identity
            if identity.ids is None or link not in (None, patch.link):
                continue
            rows = np.flatnonzero(identity.ids == number).tolist()
            if identity.aliases is not None:
                rows += identity.aliases[identity.aliases[:, 0] == number, 1].tolist()
            found += [start + row for row in dict.fromkeys(rows)]
        return readonly(found, np.int64)

    def taxel_point(self, taxel: int) -> SurfacePoint:
        """Return the position of taxel number ``taxel`` on its surface.

        Raises:
            SkinError: The skin does not have this taxel.
        """
        if not 0 <= taxel < len(self):
            raise SkinError("unknown taxel", value=taxel, remedy=f"Choose 0 to {len(self) - 1}")
        patch = int(self.patch_of[taxel])
        taxels = self.patches[patch].taxels
        local = taxel - int(self.first[patch])
        a, b, c = taxels.weights[local]
        return SurfacePoint(patch, int(taxels.faces[local]), (float(a), float(b), float(c)))

    def position(self, at: SurfacePoint) -> FloatArray:
        """Return the position (3,) of a point [m], link frame."""
        return self.patches[at.patch].surface.point(at.face, at.weights)

    def normal(self, at: SurfacePoint) -> FloatArray:
        """Return the outward unit normal (3,) at a point, link frame."""
        return self.patches[at.patch].surface.normal(at.face, at.weights)

    def link(self, at: SurfacePoint) -> str:
        """Return the name of the link under the point."""
        return self.patches[at.patch].link


def same_triangles(one: Patch, other: Patch) -> bool:
    """Return whether a ``SurfacePoint`` is the same material point on both patches.

    It is on a patch with another assumed position, but not on one with a learned surface.
    """
    return np.array_equal(one.surface.faces, other.surface.faces)


LOW_COVERAGE = 0.9
"""Share of the requested surface with taxels below which a finding warns."""


def low_coverage(where: str, coverage: float, reasons: str, remedy: str, count: int) -> Finding:
    """Return the warning that more than a tenth of the requested surface has no taxels."""
    action = f"warning: taxels on {100 * coverage:.0f} % of the requested surface; {reasons}; to cover more, {remedy}"
    return Finding("low-coverage", where, action, count)


PLACEHOLDER_COVERED = "placeholder-covered"
"""Kind of the finding for a link with a missing mesh whose placeholder has skin, because the link was named."""


def patch_name(link: str, before: int) -> str:
    """Return the name of a patch on ``link`` after ``before`` others: "forearm", "forearm 2"."""
    return link if before == 0 else f"{link} {before + 1}"


def merge_skins(skins: Sequence[Skin]) -> Skin:
    """Return one skin with all patches, each with its own name."""
    patches: list[Patch] = []
    findings: list[Finding] = []
    bare_area = sum(skin.bare_area for skin in skins)
    for skin in skins:
        findings += skin.findings
        for patch in skin.patches:
            before = sum(other.link == patch.link for other in patches)
            patches.append(Patch(patch_name(patch.link, before), patch.link, patch.surface, patch.taxels))
    return Skin(tuple(patches), tuple(findings), bare_area)
