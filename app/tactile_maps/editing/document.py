"""The edited document: a map, the settings of its patches, and the state of the patch tree.

The edits of the patch tree are here too: names, visibility and order. They do not change the map.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, fields, replace
from typing import Any

from numpy.typing import NDArray

from tactile_maps.core.errors import MapError
from tactile_maps.flattening.chart import Chart, Pin
from tactile_maps.flattening.cut import SeamPlan
from tactile_maps.maps.model.layout import MapLayout
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin


@dataclass(frozen=True, eq=False)
class PatchEdit:
    """Settings of one patch. The first four determine its chart, the others the patch tree.

    Attributes:
        method: A name in ``flattening.methods``, or the origin of an imported chart.
        lengths: 1 keeps lengths, 0 keeps angles.
        seams: Drawn and additional seams, and areas of interest.
        pins: Points of the body held at points of the chart, so that they move with it.
        name: Displayed name; the skin's name of the patch never changes.
        visible: Whether the map view shows it.
    """

    method: str
    lengths: float = 1.0
    seams: SeamPlan = field(default_factory=SeamPlan)
    pins: tuple[Pin, ...] = ()
    name: str = ""
    visible: bool = True


@dataclass(frozen=True, eq=False)
class MapDocument:
    """Everything a user can edit and save. Edits return new documents, which share unchanged parts.

    Attributes:
        map: Skin, charts and layout; the same object in documents with the same map.
        patches: Settings of each patch, in the skin's order.
        order: Patch numbers in the order of the patch tree.
    """

    map: TactileMap
    patches: tuple[PatchEdit, ...]
    order: tuple[int, ...]

    def __post_init__(self) -> None:
        count = len(self.map.charts)
        if len(self.patches) != count or sorted(self.order) != list(range(count)):
            raise MapError("the patch tree does not match the map", value=f"{len(self.patches)} for {count} patches")

    @classmethod
    def of(cls, map_: TactileMap) -> MapDocument:
        """Return a new document for a map of any origin."""
        pairs = zip(map_.skin.patches, map_.charts, strict=True)
        patches = tuple(PatchEdit(chart.method, name=patch.name) for patch, chart in pairs)
        return cls(map_, patches, tuple(range(len(patches))))

    @property
    def skin(self) -> Skin:
        """The mapped skin; the same in all documents of a history."""
        return self.map.skin

    @property
    def charts(self) -> tuple[Chart, ...]:
        """Chart of each patch."""
        return self.map.charts

    @property
    def layout(self) -> MapLayout:
        """Placements of the charts."""
        return self.map.layout

    def chosen(self, numbers: Iterable[int]) -> list[int]:
        """Return sorted unique patch numbers.

        Raises:
            MapError: Unknown patch number.
        """
        known = range(len(self.patches))
        result = sorted(set(numbers))
        for number in result:
            if number not in known:
                raise MapError("unknown patch number", value=number, remedy=f"The map has {len(known)}, from 0")
        return result

    def with_layout(self, layout: MapLayout) -> MapDocument:
        """Return the document with another layout."""
        return replace(self, map=replace(self.map, layout=layout))

    def with_patch(self, number: int, edit: PatchEdit) -> MapDocument:
        """Return the document with other settings of a patch and an unchanged chart."""
        return replace(self, patches=(*self.patches[:number], edit, *self.patches[number + 1 :]))

    def arrays(self) -> Iterator[NDArray[Any]]:
        """Yield the arrays that edits change, shared ones included, to measure the memory of a history."""
        for chart in self.charts:
            yield from (chart.faces, chart.plane, chart.vertex_of, chart.seams)
        for patch in self.patches:
            yield patch.seams.drawn
            if patch.seams.importance is not None:
                yield patch.seams.importance

    def release_caches(self, present: MapDocument) -> None:
        """Delete cached values of map and charts that ``present`` does not share.

        They are recomputed when needed.
        """
        mine: tuple[TactileMap | Chart, ...] = (self.map, *self.charts)
        for value in mine:
            if not any(value is shared for shared in (present.map, *present.charts)):
                for name in set(vars(value)) - {part.name for part in fields(value)}:
                    del vars(value)[name]


LONGEST_NAME = 100
"""Largest number of characters of a name."""


def rename_patch(document: MapDocument, number: int, name: str) -> MapDocument:
    """Rename patch ``number``; leading and trailing spaces are dropped.

    Raises:
        MapError: Unknown patch, or a name that is empty, too long, not printable on one line, or used by another patch.
    """
    (number,) = document.chosen([number])
    name = name.strip()
    if not name or len(name) > LONGEST_NAME or not name.isprintable():
        raise MapError("this is not a valid patch name", value=name, remedy=f"Write 1 to {LONGEST_NAME} characters")
    if any(patch.name == name for k, patch in enumerate(document.patches) if k != number):
        raise MapError("another patch has this name", value=name, remedy="Choose another name")
    if name == document.patches[number].name:
        return document
    return document.with_patch(number, replace(document.patches[number], name=name))


def show_patches(document: MapDocument, numbers: Iterable[int], *, visible: bool = True) -> MapDocument:
    """Show or hide patches; hidden ones are simulated and controlled as before."""
    for number in document.chosen(numbers):
        if document.patches[number].visible != visible:
            document = document.with_patch(number, replace(document.patches[number], visible=visible))
    return document


def reorder_patch(document: MapDocument, number: int, to: int) -> MapDocument:
    """Move patch ``number`` to position ``to`` of the tree, from 0; the others keep their order.

    Raises:
        MapError: Unknown patch or position.
    """
    (number,) = document.chosen([number])
    if not 0 <= to < len(document.order):
        raise MapError("invalid position in the patch tree", value=to, remedy=f"0 to {len(document.order) - 1}")
    rest = [k for k in document.order if k != number]
    order = (*rest[:to], number, *rest[to:])
    return document if order == document.order else replace(document, order=order)
