"""The skin: patches on links, the taxels of each patch, and all taxels numbered through.

A taxel sits on its patch's surface and answers for an area; the area is carried by quadrature points, where pressure is
evaluated before it is summed by taxel.

Inside the program a taxel is its running number. That changes with the file, the fit and the order of the patches; its
identity, what a robot's own electronics call it (id, module, and channel on that module's board), is what readings are
tied to, and goes along unchanged. Ids may repeat where several boards count for themselves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray, freeze_arrays, readonly
from tactile_maps.core.errors import Finding, SkinError
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint

LARGEST_NUMBER = 2**31 - 1
"""Of an id, a module or a channel: what the boards count in."""
IDENTITY_FIELDS = ("ids", "modules", "channels")
"""Those of an identity that are numbers."""
LONGEST_NAME = 200


@dataclass(frozen=True)
class TaxelName:
    """The identity of one taxel; None where it is not known."""

    id: int | None = None
    module: int | None = None
    channel: int | None = None
    name: str | None = None

    def __str__(self) -> str:
        """``thumb_touch, id 87012, module 14, channel 3``; empty where nothing is known."""
        parts = (("id", self.id), ("module", self.module), ("channel", self.channel))
        numbers = (f"{word} {number}" for word, number in parts if number is not None)
        return ", ".join((*(() if self.name is None else (self.name,)), *numbers))


@dataclass(frozen=True, eq=False)
class TaxelIdentity:
    """The identity of each of n taxels; an array is None where nothing states it.

    Attributes:
        ids: (n,) hardware ids, as stated; they may repeat.
        modules: (n,) the module, or board, that carries each taxel.
        channels: (n,) the place of each taxel among those of its module.
        names: (n,) what each taxel, or the sensor it is part of, is called; they may repeat.

    Raises:
        SkinError: An array is not of one axis, they differ in length, a number is not from 0 to 2³¹ - 1, or a name is
            longer than 200 characters.
    """

    ids: IntArray | None = None
    modules: IntArray | None = None
    channels: IntArray | None = None
    names: tuple[str, ...] | None = None

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
        if self.names is not None:
            if count is not None and len(self.names) != count:
                raise SkinError("the numbers of rows or columns do not fit", place="names", value=len(self.names))
            for row, name in enumerate(self.names):
                if len(name) > LONGEST_NAME:
                    problem = f"a name is longer than {LONGEST_NAME} characters"
                    raise SkinError(problem, place=f"names, row {row}", value=f"{name[:40]}...")

    def __len__(self) -> int:
        """The number of taxels, 0 where nothing is known."""
        return next((len(values) for values in (*self._arrays(), self.names) if values is not None), 0)

    @property
    def known(self) -> bool:
        """Whether anything is."""
        return any(values is not None for values in (*self._arrays(), self.names))

    def select(self, rows: IntArray) -> TaxelIdentity:
        """Of the taxels in ``rows`` (k,), in that order."""
        names = None if self.names is None else tuple(self.names[row] for row in np.asarray(rows).tolist())
        ids, modules, channels = (None if values is None else values[rows] for values in self._arrays())
        return TaxelIdentity(ids, modules, channels, names)

    def name(self, row: int) -> TaxelName:
        """Of one taxel."""
        number, module, channel = (None if values is None else int(values[row]) for values in self._arrays())
        return TaxelName(number, module, channel, None if self.names is None else self.names[row])

    def _arrays(self) -> tuple[IntArray | None, ...]:
        return self.ids, self.modules, self.channels


NO_IDENTITY = TaxelIdentity()


def join_identities(parts: Sequence[TaxelIdentity]) -> TaxelIdentity:
    """Of the taxels of all ``parts``, one after the other; an array that one of them lacks is None."""
    columns = ([getattr(part, field) for part in parts] for field in IDENTITY_FIELDS)
    ids, modules, channels = (
        np.concatenate(arrays) if arrays and all(a is not None for a in arrays) else None for arrays in columns
    )
    named = [part.names for part in parts if part.names is not None]
    names = tuple(chain(*named)) if named and len(named) == len(parts) else None
    return TaxelIdentity(ids, modules, channels, names)


def identity_summary(identity: TaxelIdentity) -> dict[str, dict[str, int]]:
    """For each array that is known: how many different numbers, the first and the last, and for ids how many repeat; of
    names how many are different.
    """
    found = {}
    for field in IDENTITY_FIELDS:
        values: IntArray | None = getattr(identity, field)
        if values is not None and len(values):
            counts = np.unique(values, return_counts=True)[1]
            repeated = int((counts > 1).sum()) if field == "ids" else 0
            found[field] = {
                "different": len(counts), "first": int(values.min()), "last": int(values.max()), "repeated": repeated
            }  # fmt: skip
    if identity.names:
        found["names"] = {"different": len(set(identity.names))}
    return found


def identity_text(summary: Mapping[str, Mapping[str, int]]) -> str:
    """``ids 86999 to 87438 (440), modules 0 to 63 (44)``: an ``identity_summary`` in words; empty for nothing."""
    parts = []
    for field, found in summary.items():
        if field == "names":
            parts.append(f"{found['different']} names")
            continue
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


@dataclass(frozen=True, eq=False)
class Quadrature:
    """Evenly spread points that carry the patch's area; contact pressure is evaluated here, then summed by taxel.

    Ten to thirty a taxel: fewer miss contacts smaller than the pitch, more do not increase the accuracy.

    Attributes:
        positions: (q, 3) [m], link frame.
        normals: (q, 3) outward unit normals, link frame.
        areas: (q,) [m²]; they sum to the area that the taxels answer for.
        taxel: (q,) index of the taxel that each point belongs to, within the patch.
    """

    positions: FloatArray
    normals: FloatArray
    areas: FloatArray
    taxel: IntArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "positions", "normals", "areas")
        freeze_arrays(self, "taxel", dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Taxels:
    """The taxels of one patch.

    Attributes:
        positions: (n, 3) [m], link frame, on the patch's surface.
        normals: (n, 3) outward unit normals.
        faces: (n,) triangle of the patch's surface that holds each taxel.
        weights: (n, 3) barycentric weights in that triangle.
        areas: (n,) [m²], each > 0; the sum of its quadrature points' areas.
        neighbours: (e, 2) pairs of taxels whose areas touch on the body (a seam does not separate them), i < j.
        quadrature: Where pressure is evaluated.
        identity: What the robot's electronics call each of them, where a file stated it.

    Raises:
        SkinError: The identity is of another number of taxels.
    """

    positions: FloatArray
    normals: FloatArray
    faces: IntArray
    weights: FloatArray
    areas: FloatArray
    neighbours: IntArray
    quadrature: Quadrature
    identity: TaxelIdentity = NO_IDENTITY

    def __post_init__(self) -> None:
        freeze_arrays(self, "positions", "normals", "weights", "areas")
        freeze_arrays(self, "faces", "neighbours", dtype=np.int64)
        if self.identity.known and len(self.identity) != len(self.positions):
            found = f"{len(self.identity)} of {len(self.positions)} taxels"
            raise SkinError("the identity is of another number of taxels", place="identity", value=found)

    def __len__(self) -> int:
        return len(self.positions)


@dataclass(frozen=True, eq=False)
class Patch:
    """A piece of skin that covers one link.

    Attributes:
        name: Unique in the skin.
        link: Name of the link that it covers.
        surface: The outer surface in the link frame, not cut: what a finger meets. Connected and manifold.
        taxels: What it feels with.
    """

    name: str
    link: str
    surface: Mesh
    taxels: Taxels


@dataclass(frozen=True, eq=False)
class BarePoints:
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

    def __post_init__(self) -> None:
        freeze_arrays(self, "positions", "normals", "areas")


@dataclass(frozen=True, eq=False)
class Skin:
    """All patches of a robot; taxel numbers run through the patches in order.

    Attributes:
        patches: In a stable order.
        findings: What was noticed and repaired while making it.
        bare_area: Area of the requested surface that got no taxels [m²]: pieces too small for a taxel, places of a grid
            beyond an edge. Surface that was not requested, such as inner walls, does not count.
        bare_points: Surface of the links that bears load next to the skin, as contact models need it; empty unless
            added by ``bare_surface.with_bare_points``. Files do not store it.

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
        """The number of taxels."""
        return int(self.first[-1])

    @cached_property
    def areas(self) -> FloatArray:
        """(n,) [m²]."""
        return readonly(np.concatenate([p.taxels.areas for p in self.patches]) if self.patches else np.zeros(0))

    @cached_property
    def patch_of(self) -> IntArray:
        """(n,) patch index of each taxel."""
        return readonly(np.repeat(np.arange(len(self.patches)), np.diff(self.first)), np.int64)

    @cached_property
    def neighbours(self) -> IntArray:
        """(e, 2) neighbouring taxels, numbered through the skin."""
        pairs = [p.taxels.neighbours + start for p, start in zip(self.patches, self.first[:-1], strict=True)]
        return readonly(np.concatenate(pairs) if pairs else np.zeros((0, 2)), np.int64)

    @cached_property
    def identity(self) -> TaxelIdentity:
        """Of all taxels, numbered through the skin; what only some patches state is None here."""
        return join_identities([patch.taxels.identity for patch in self.patches if len(patch.taxels)])

    def taxel_name(self, taxel: int) -> TaxelName:
        """What the robot's electronics call taxel number ``taxel``, as far as its patch states it."""
        patch = int(self.patch_of[taxel])
        return self.patches[patch].taxels.identity.name(taxel - int(self.first[patch]))

    def taxels_named(self, name: str) -> IntArray:
        """(k,) running numbers of the taxels of that name, whatever its letters' case: all cells of a sensor."""
        wanted = name.casefold()
        parts = zip(self.first[:-1].tolist(), self.patches, strict=True)
        names = [(start, patch.taxels.identity.names) for start, patch in parts]
        found = [start + row for start, own in names if own for row, one in enumerate(own) if one.casefold() == wanted]
        return readonly(found, np.int64)

    def taxels_with_id(self, number: int) -> IntArray:
        """(k,) running numbers of the taxels whose hardware id is ``number``: several where boards repeat ids."""
        found = [
            start + np.flatnonzero(patch.taxels.identity.ids == number)
            for patch, start in zip(self.patches, self.first[:-1], strict=True)
            if patch.taxels.identity.ids is not None
        ]
        return readonly(np.concatenate(found) if found else np.zeros(0), np.int64)

    def taxel_point(self, taxel: int) -> SurfacePoint:
        """Where taxel number ``taxel`` sits."""
        patch = int(self.patch_of[taxel])
        taxels = self.patches[patch].taxels
        local = taxel - int(self.first[patch])
        a, b, c = taxels.weights[local]
        return SurfacePoint(patch, int(taxels.faces[local]), (float(a), float(b), float(c)))

    def position(self, at: SurfacePoint) -> FloatArray:
        """(3,) [m], link frame of the patch's link."""
        return self.patches[at.patch].surface.point(at.face, at.weights)

    def normal(self, at: SurfacePoint) -> FloatArray:
        """(3,) outward unit normal, link frame."""
        return self.patches[at.patch].surface.normal(at.face, at.weights)

    def link(self, at: SurfacePoint) -> str:
        """Name of the link under the point."""
        return self.patches[at.patch].link


def same_triangles(one: Patch, other: Patch) -> bool:
    """Whether a ``SurfacePoint`` of one is, materially, the same place on the other: so it is on a skin that is only
    believed to lie elsewhere, and not on one whose surface was learned.
    """
    return np.array_equal(one.surface.faces, other.surface.faces)


LOW_COVERAGE = 0.9
"""Share of the requested surface with taxels below which a finding warns."""


def low_coverage(where: str, coverage: float, reasons: str, remedy: str, count: int) -> Finding:
    """The warning that taxels are missing on more than a tenth of the requested surface."""
    action = f"warning: taxels on {100 * coverage:.0f} % of the requested surface; {reasons}; to cover more, {remedy}"
    return Finding("low-coverage", where, action, count)


PLACEHOLDER_COVERED = "placeholder-covered"
"""Kind of the finding for a link with a missing mesh whose placeholder has skin, because the link was named."""


def patch_name(link: str, before: int) -> str:
    """Name of the patch on ``link`` when ``before`` others have been named: "forearm", "forearm 2"."""
    return link if before == 0 else f"{link} {before + 1}"


def merge_skins(skins: Sequence[Skin]) -> Skin:
    """All patches in one skin, each with a name of its own."""
    patches: list[Patch] = []
    findings: list[Finding] = []
    bare_area = sum(skin.bare_area for skin in skins)
    for skin in skins:
        findings += skin.findings
        for patch in skin.patches:
            before = sum(other.link == patch.link for other in patches)
            patches.append(Patch(patch_name(patch.link, before), patch.link, patch.surface, patch.taxels))
    return Skin(tuple(patches), tuple(findings), bare_area)
