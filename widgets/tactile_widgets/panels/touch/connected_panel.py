"""Base class of the panels of a connected skin."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import TactileMapsError
from tactile_widgets.common.make import make
from tactile_widgets.common.panel import Panel
from tactile_widgets.document.taxel_selection import TaxelSelection
from tactile_widgets.session.live_input import LiveInput


class ConnectedPanel(Panel):
    """A panel that is hidden while nothing is connected, and refreshed by a timer while something is.

    Args:
        heading: Heading of the panel.
        name: Object name.
        refresh_ms: Interval of ``refresh`` [ms]; 0 for no timer.
        parent: Qt parent.
    """

    def __init__(self, heading: str, name: str, refresh_ms: int = 0, parent: QWidget | None = None) -> None:
        super().__init__(heading, name, parent)
        self._input: LiveInput | None = None
        self._selection: TaxelSelection
        self._refresh_ms = refresh_ms
        self._timer = make(QTimer, self, timeout=self.refresh)
        self.folded_changed.connect(self._on_folded_changed)
        self.hide()

    def follow(self, selection: TaxelSelection) -> None:
        """Use the taxels selected in the views."""
        self._selection = selection

    def show_input(self, live: LiveInput | None) -> None:
        """Show another live input; None if there is none."""
        self._input = live
        self.setVisible(live is not None)
        self._on_folded_changed()
        if live is None:
            self._timer.stop()
        elif self._refresh_ms:
            self._timer.start(self._refresh_ms)
            self.refresh()

    def set_folded(self, folded: bool) -> None:
        super().set_folded(folded)
        self._on_folded_changed()

    def refresh(self) -> None:
        """Show the current state."""

    def _on_folded_changed(self) -> None:
        """Start or stop what is computed for an unfolded panel only."""

    def _try(self, act: Callable[[LiveInput], None]) -> str:
        """Call ``act`` with the live input; return the message of an error, or an empty text."""
        try:
            if self._input is not None:
                act(self._input)
        except TactileMapsError as error:
            return str(error)
        return ""
