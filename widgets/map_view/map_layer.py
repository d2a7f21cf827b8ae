"""What a layer of View > Overlay draws on the map: one protocol, so that the scene needs to know none by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from PySide6.QtWidgets import QGraphicsItem

from app.editing.document import MapDocument
from app.session.frame import Frame
from widgets.common.colours import Theme
from widgets.map_view.map_shapes import MapShapes


class MapLayer(Protocol):
    """Items of one layer, made once a skin."""

    @property
    def items(self) -> Sequence[QGraphicsItem]:
        """What goes into the graphics scene, which owns it from then on."""

    def show_document(self, document: MapDocument, shapes: MapShapes) -> None:
        """The map was edited, or is shown first: ``shapes`` says where all of it lies [scene units]."""

    def show_frame(self, frame: Frame) -> None:
        """Another instant."""

    def set_shown(self, *, shown: bool) -> None:
        """Show the items, or hide them."""

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""


MapLayerFactory = Callable[[MapDocument, Theme], MapLayer]
"""Makes a layer for a document's skin."""
