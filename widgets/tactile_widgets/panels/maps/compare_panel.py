"""Comparison of the map with another layout of the same skin: shown in turn, measured side by side, and applied."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QButtonGroup, QPushButton, QWidget

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.layout_import import (
    ImportedLayout,
    adopt_document,
    arrange_as_drawn,
    pin_as_drawn,
    read_other_layout,
    same_skin,
)
from tactile_maps.maps.evaluation.comparison import Comparison, TaxelLayout
from tactile_widgets.common.make import button_grid, push_button, show_text
from tactile_widgets.common.panel import Panel
from tactile_widgets.common.sentence import capitalized
from tactile_widgets.document.map_editor import MapEditor

_MARK = "▲"
_NAME_PX = 104
_EMPTY = "Compare with another map: a saved one, taxel positions drawn by hand, or the current state of this one."
_REPLAYING = "A replay shows the recorded map; return to the session to compare it."
_DRAWING = "B has taxel positions only: it is measured, not displayed. Applying it pins taxels to these positions."
_SIDE_TIPS = {False: "Show B in the map view, read-only; an edit returns to A", True: _DRAWING}
_APPLY_TIPS = {
    False: "Apply charts, arrangement and pins of B to this map; one undo step",
    True: "Fit each patch to the positions in B, and pin its taxels there; two undo steps",
}


class ComparePanel(Panel):
    """Comparison of A, the map being edited, with B, the other layout.

    Args:
        editor: Editor of A.
        parent: Qt parent.

    Attributes:
        other: B, which is a MapDocument, a TaxelLayout if it has taxel positions only, or None.
    """

    files_requested = Signal()
    """The user chooses another layout; the receiver asks for its files and calls ``open_paths``."""
    shown_other = Signal(bool)
    """True if the map view shows ``other`` instead of the editor's document."""
    compare_requested = Signal(object, object)
    """A TactileMap, and a TactileMap or TaxelLayout, to be measured in the background."""
    compared = Signal(Comparison)
    """Result for the quality card."""
    ended = Signal()
    """Emitted when the other layout was removed."""
    search_words = "maps"

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__("Compare", "compare-panel", parent)
        self._editor = editor
        self._name = ""
        self.other: ImportedLayout | None = None
        self._document = editor.document
        self._note = self.caption(_EMPTY, "compare-note")
        load = self._button(
            "with", "Compare with…", "Open a saved map, or a file of taxel positions on a map", self.files_requested
        )
        keep = self._button("keep", "Set current as B", "Compare later edits with the current map", self.keep_present)
        self._sides = QButtonGroup(self)
        self._a = self._button("a", "A: this map", "Show the edited map")
        self._b = self._button("b", "B", "")
        for side in (self._a, self._b):
            side.setCheckable(True)
            self._sides.addButton(side)
        self._a.setChecked(True)
        self._b.toggled.connect(self.shown_other)
        self._apply = self._button("take", "Apply B", "", self._on_apply_clicked)
        clear = self._button("forget", "Clear B", "Stop comparing", self._on_clear_clicked)
        self._sources = (load, keep)
        self._commands = (self._a, self._b, self._apply, clear)
        self.column.addLayout(button_grid((*self._sources, *self._commands)))
        editor.shown.connect(self._on_shown)
        editor.settled.connect(self._on_settled)
        editor.enabled_changed.connect(self._update_state)
        self._update_state()

    @property
    def shows_other(self) -> bool:
        """Whether B is shown."""
        return self._b.isChecked()

    def open_paths(self, paths: Sequence[str | Path]) -> bool:
        """Compare with the layout in files; if it cannot be compared, B stays and the reason is shown.

        Return whether it is compared.
        """
        if self._editor.document is None:
            return False
        try:
            other = read_other_layout(paths, self._editor.document)
        except TactileMapsError as error:
            self.show_failed(str(error))
            return False
        self._set_other(other, Path(paths[0]).stem)
        return True

    def keep_present(self) -> None:
        """Use the current map as B."""
        history = self._editor.history
        if history is not None:
            self._set_other(history.present, f"after {history.names[history.position]}")

    @property
    def can_show_other(self) -> bool:
        """Whether there is a B that the view can show."""
        return not self._b.isHidden() and self._b.isEnabled()

    def toggle(self) -> None:
        """Switch between A and B, if B can be shown."""
        if self.can_show_other:
            self._show_b(shown=not self.shows_other)

    def show_comparison(self, comparison: Comparison) -> None:
        """Take the result of the last request."""
        if self.other is not None:
            self._update_state()
            self.compared.emit(comparison)

    def show_failed(self, text: str) -> None:
        """Show why a layout cannot be compared."""
        show_text(self._note, f"{_MARK} {capitalized(text)}")

    def _button(self, name: str, text: str, tip: str, clicked: object = None) -> QPushButton:
        return push_button(self, f"compare-{name}", text, tip, clicked)

    def _set_other(self, other: ImportedLayout | None, name: str = "") -> None:
        self._show_b(shown=False)
        self.other = other
        self._name = name
        self._update_state()
        if other is None:
            self.ended.emit()
        else:
            self._compare()

    def _compare(self) -> None:
        document = self._editor.document
        other = self.other
        if document is not None and other is not None:
            show_text(self._note, "Measuring both…")
            self.compare_requested.emit(document.map, other.map if isinstance(other, MapDocument) else other)

    def _update_state(self) -> None:
        """Show one of the states empty, comparing, or disabled by a replay."""
        other = self.other
        on = self._editor.enabled
        drawn = isinstance(other, TaxelLayout)
        replaying = self._editor.document is not None and not on
        show_text(self._note, _REPLAYING if replaying else _EMPTY if other is None else _DRAWING if drawn else "")
        for button in (*self._sources, *self._commands):
            button.setEnabled(on)
        for button in self._commands:
            button.setHidden(other is None)
        name = f"B: {self._name}"
        self._b.setText(self._b.fontMetrics().elidedText(name, Qt.TextElideMode.ElideRight, _NAME_PX))
        self._b.setAccessibleName(name)
        self._b.setEnabled(on and not drawn)
        self._b.setToolTip(f"{name}\n{_SIDE_TIPS[drawn]}")
        self._apply.setToolTip(_APPLY_TIPS[drawn])

    def _show_b(self, *, shown: bool) -> None:
        (self._b if shown else self._a).setChecked(True)

    def _on_apply_clicked(self) -> None:
        other = self.other
        if isinstance(other, MapDocument):
            self._editor.do(f"Apply map {self._name}", partial(adopt_document, other=other))
        elif other is not None:
            self._editor.do("Arrange as in the drawing", partial(arrange_as_drawn, drawing=other))
            self._editor.ask(partial(pin_as_drawn, drawing=other))
        self._show_b(shown=False)

    def _on_clear_clicked(self) -> None:
        self._set_other(None)

    def _on_shown(self, _document: MapDocument) -> None:
        """Show A, which was edited."""
        self._show_b(shown=False)

    def _on_settled(self, document: MapDocument, _step: str) -> None:
        before = self._document
        self._document = document
        if self.other is None:
            self._update_state()
        elif before is not None and not same_skin(before.skin, document.skin):
            self._set_other(None)  # another robot was opened
        elif before is None or before.map is not document.map:
            self._compare()
