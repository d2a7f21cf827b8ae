"""A map as a person edits it: the map, how each patch of it came about, and how the patch tree shows it.

The edits of the patch tree are here too: names, what is shown, and in which order. The map itself stays as it is.
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
    """What a person wants of one patch. The first four make its chart, the others are for the patch tree.

    Attributes:
        method: A name in ``flattening.methods``, or how a chart that came from elsewhere was made.
        lengths: From 1, keep lengths, to 0, keep angles.
        seams: Drawn and further seams, and areas of interest.
        pins: Places of the body held at places of the plane, in the chart's own frame, so that they move with it.
        name: Shown to people; the skin's own name for the patch never changes.
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
    """All that a person can edit and save. Edits give new documents, which share whatever they did not change.

    Attributes:
        map: Skin, charts and layout; the very same object in documents that show the same map.
        patches: What is wanted of each patch, in the skin's order.
        order: Patch numbers in the order of the patch tree.
    """

    map: TactileMap
    patches: tuple[PatchEdit, ...]
    order: tuple[int, ...]

    def __post_init__(self) -> None:
        count = len(self.map.charts)
        if len(self.patches) != count or sorted(self.order) != list(range(count)):
            raise MapError("the patch tree is not that of the map", value=f"{len(self.patches)} for {count} patches")

    @classmethod
    def of(cls, map_: TactileMap) -> MapDocument:
        """A first document around a map, however it was made."""
        pairs = zip(map_.skin.patches, map_.charts, strict=True)
        patches = tuple(PatchEdit(chart.method, name=patch.name) for patch, chart in pairs)
        return cls(map_, patches, tuple(range(len(patches))))

    @property
    def skin(self) -> Skin:
        """What is mapped; the same in all documents of a history."""
        return self.map.skin

    @property
    def charts(self) -> tuple[Chart, ...]:
        """Each patch, flattened."""
        return self.map.charts

    @property
    def layout(self) -> MapLayout:
        """Where the charts lie."""
        return self.map.layout

    def chosen(self, numbers: Iterable[int]) -> list[int]:
        """Patch numbers in order, each once.

        Raises:
            MapError: There is no such patch.
        """
        known = range(len(self.patches))
        wanted = sorted(set(numbers))
        for number in wanted:
            if number not in known:
                raise MapError("there is no such patch", value=number, remedy=f"The map has {len(known)}, from 0")
        return wanted

    def with_layout(self, layout: MapLayout) -> MapDocument:
        """The same charts, arranged otherwise."""
        return replace(self, map=replace(self.map, layout=layout))

    def with_patch(self, number: int, edit: PatchEdit) -> MapDocument:
        """Another name or visibility for a patch, its chart being as it was."""
        return replace(self, patches=(*self.patches[:number], edit, *self.patches[number + 1 :]))

    def arrays(self) -> Iterator[NDArray[Any]]:
        """The arrays that edits change, shared ones too, for counting what a history holds."""
        for chart in self.charts:
            yield from (chart.faces, chart.plane, chart.vertex_of, chart.seams)
        for patch in self.patches:
            yield patch.seams.drawn
            if patch.seams.importance is not None:
                yield patch.seams.importance

    def release_caches(self, present: MapDocument) -> None:
        """Let go of what was computed from map and charts that ``present`` does not share.

        Whoever asks again has it computed again.
        """
        mine: tuple[TactileMap | Chart, ...] = (self.map, *self.charts)
        for value in mine:
            if not any(value is shared for shared in (present.map, *present.charts)):
                for name in set(vars(value)) - {part.name for part in fields(value)}:
                    del vars(value)[name]


LONGEST_NAME = 100
"""Characters of a name."""


def rename_patch(document: MapDocument, number: int, name: str) -> MapDocument:
    """Patch ``number`` called ``name``; spaces at the ends do not count.

    Raises:
        MapError: No such patch, or a name that is empty, too long, of more than one line, or another patch's.
    """
    (number,), wanted = document.chosen([number]), name.strip()
    if not wanted or len(wanted) > LONGEST_NAME or not wanted.isprintable():
        raise MapError("this is not a valid patch name", value=name, remedy=f"Write 1 to {LONGEST_NAME} characters")
    if any(patch.name == wanted for k, patch in enumerate(document.patches) if k != number):
        raise MapError("another patch has this name", value=wanted, remedy="Choose another name")
    if wanted == document.patches[number].name:
        return document
    return document.with_patch(number, replace(document.patches[number], name=wanted))


def show_patches(document: MapDocument, numbers: Iterable[int], *, visible: bool = True) -> MapDocument:
    """The patches shown, or hidden: they feel and are controlled all the same."""
    for number in document.chosen(numbers):
        if document.patches[number].visible != visible:
            document = document.with_patch(number, replace(document.patches[number], visible=visible))
    return document


def reorder_patch(document: MapDocument, number: int, to: int) -> MapDocument:
    """Patch ``number`` at place ``to`` of the tree, 0 first; the others keep their order.

    Raises:
        MapError: No such patch or no such place.
    """
    (number,) = document.chosen([number])
    if not 0 <= to < len(document.order):
        raise MapError("there is no such place in the tree", value=to, remedy=f"0 to {len(document.order) - 1}")
    rest = [k for k in document.order if k != number]
    order = (*rest[:to], number, *rest[to:])
    return document if order == document.order else replace(document, order=order)
