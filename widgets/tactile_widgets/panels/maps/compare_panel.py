"""The map beside another layout of the same skin: seen in turn, measured side by side, and taken over."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QButtonGroup, QFileDialog, QGridLayout, QPushButton, QWidget

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
from tactile_widgets.common.panel import Panel
from tactile_widgets.document.map_editor import MapEditor

FILTER = "Maps and drawings (*.npz *.json *.csv *.tsv *.txt *.ini *.urdf *.xml);;All files (*)"
_MARK = "▲"
_NAME_PX = 104
_EMPTY = "Compare with another map: a saved one, taxel positions drawn by hand, or this one as it is now."
_REPLAYING = "A replay shows the map as it was; go back to live to compare it."
_DRAWING = "B has taxel positions only: it is measured, not displayed. Applying it pins taxels to these positions."
_SIDE_TIPS = {False: "Show B in the map view, read-only; an edit returns to A", True: _DRAWING}
_TAKE_TIPS = {
    False: "Apply charts, arrangement and pins of B to this map; one undo step",
    True: "Fit each patch to the positions in B, and pin its taxels there; two undo steps",
}


class ComparePanel(Panel):
    """A is the map that is edited, B the other layout.

    Args:
        editor: Of A.
        parent: Qt parent.
    """

    shown_other = Signal(bool)
    """Whether the map view is to show ``other`` instead of the editor's document."""
    compare_requested = Signal(object, object)
    """A TactileMap, and a TactileMap or TaxelLayout, to be measured where it does not hold up the window."""
    compared = Signal(Comparison)
    """Result for the quality card."""
    ended = Signal()
    """There is nothing to compare with any more."""

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__("Compare", "compare-panel", parent)
        self._editor = editor
        self._name = ""
        self._other: ImportedLayout | None = None
        self._document = editor.document
        self._note = self.caption(_EMPTY)
        self._note.setObjectName("compare-note")
        grid = QGridLayout()
        grid.setSpacing(4)
        self.column.addLayout(grid)
        self._with = self._button(
            "with", "Compare with…", "Open a saved map, or a file of taxel positions on a map", self.choose
        )
        self._keep = self._button(
            "keep", "Set current as B", "Compare later edits with the map as it is now", self.keep_present
        )
        self._sides = QButtonGroup(self)
        self._a, self._b = self._side("A: this map"), self._side("B")
        self._a.setToolTip("Show the edited map")
        self._a.setChecked(True)
        self._b.toggled.connect(self._on_b_toggled)
        self._take = self._button("take", "Apply B", "", self._on_take_clicked)
        self._forget = self._button("forget", "Clear B", "Stop comparing", self._on_forget_clicked)
        for place, button in enumerate((self._with, self._keep, self._a, self._b, self._take, self._forget)):
            grid.addWidget(button, *divmod(place, 2))
        editor.shown.connect(self._on_shown)
        editor.settled.connect(self._on_settled)
        editor.enabled_changed.connect(self._update_state)
        self._update_state()

    @property
    def other(self) -> ImportedLayout | None:
        """B: a MapDocument, a TaxelLayout where only taxels were drawn, or None."""
        return self._other

    @property
    def shows_other(self) -> bool:
        """Whether B is to be seen."""
        return self._b.isChecked()

    def choose(self, _checked: bool = False) -> None:
        """Ask for the files of another layout."""
        paths, _ = QFileDialog.getOpenFileNames(self, "Compare with", "", FILTER)
        if paths:
            self.open_paths(paths)

    def open_paths(self, paths: Sequence[str | Path]) -> None:
        """Compare with what the files hold; what cannot be compared is refused, and B stays."""
        if self._editor.document is None:
            return
        try:
            other = read_other_layout(paths, self._editor.document)
        except TactileMapsError as error:
            self.show_failed(str(error))
        else:
            self._set_other(other, Path(paths[0]).stem)

    def keep_present(self, _checked: bool = False) -> None:
        """The map as it is now is B from here on."""
        history = self._editor.history
        if history is not None:
            self._set_other(history.present, history.names[history.position])

    @property
    def can_show_other(self) -> bool:
        """Whether there is a B that the view can show."""
        return not self._b.isHidden() and self._b.isEnabled()

    def toggle(self) -> None:
        """Show B in the view instead of A, or A again, where B can be shown."""
        if self.can_show_other:
            self._show_b(shown=not self.shows_other)

    def show_comparison(self, comparison: Comparison) -> None:
        """The numbers asked for last."""
        if self._other is not None:
            self._update_state()
            self.compared.emit(comparison)

    def show_failed(self, text: str) -> None:
        """Say why something cannot be compared."""
        self._note.setText(f"{_MARK} {text[:1].upper()}{text[1:]}")
        self._note.show()

    # Inside.

    def _button(self, name: str, text: str, tip: str, slot: object) -> QPushButton:
        button = QPushButton(text, self)
        button.setObjectName(f"compare-{name}")
        button.setToolTip(tip)
        button.clicked.connect(slot)
        return button

    def _side(self, text: str) -> QPushButton:
        side = QPushButton(text, self)
        side.setObjectName("compare-" + text[0].lower())
        side.setCheckable(True)
        self._sides.addButton(side)
        return side

    def _set_other(self, other: ImportedLayout | None, name: str = "") -> None:
        self._show_b(shown=False)
        self._other = other
        self._name = name
        self._update_state()
        if other is None:
            self.ended.emit()
        else:
            self._ask()

    def _ask(self) -> None:
        document = self._editor.document
        other = self._other
        if document is not None and other is not None:
            self._note.setText("Measuring both…")
            self._note.show()
            self.compare_requested.emit(document.map, other.map if isinstance(other, MapDocument) else other)

    def _update_state(self) -> None:
        """Empty, comparing, or shut while a recording is replayed."""
        document = self._editor.document
        other = self._other
        on = self._editor.enabled
        drawn = isinstance(other, TaxelLayout)
        note = _REPLAYING if document is not None and not on else _EMPTY if other is None else _DRAWING if drawn else ""
        self._note.setText(note)
        self._note.setHidden(not note)
        for button in (self._with, self._keep):
            button.setEnabled(on)
        for button in (self._a, self._b, self._take, self._forget):
            button.setHidden(other is None)
            button.setEnabled(on)
        name = f"B: {self._name}"
        self._b.setText(self._b.fontMetrics().elidedText(name, Qt.TextElideMode.ElideRight, _NAME_PX))
        self._b.setAccessibleName(name)
        self._b.setEnabled(on and not drawn)
        self._b.setToolTip(f"{name}\n{_SIDE_TIPS[drawn]}")
        self._take.setToolTip(_TAKE_TIPS[drawn])

    def _show_b(self, *, shown: bool) -> None:
        (self._b if shown else self._a).setChecked(True)

    def _on_b_toggled(self, shown: bool) -> None:
        self.shown_other.emit(shown)

    def _on_take_clicked(self, _checked: bool = False) -> None:
        other = self._other
        if isinstance(other, MapDocument):
            self._editor.do(f"Apply {self._name}", partial(adopt_document, other=other))
        elif other is not None:
            self._editor.do("Arrange as in the drawing", partial(arrange_as_drawn, drawing=other))
            self._editor.ask(partial(pin_as_drawn, drawing=other))
        self._show_b(shown=False)

    def _on_forget_clicked(self, _checked: bool = False) -> None:
        self._set_other(None)

    def _on_shown(self, _document: MapDocument) -> None:
        """An edit: it is A that is edited, so A is what must be seen."""
        self._show_b(shown=False)

    def _on_settled(self, document: MapDocument, _step: str) -> None:
        before = self._document
        self._document = document
        if self._other is None:
            self._update_state()
        elif before is not None and not same_skin(before.skin, document.skin):
            self._set_other(None)  # another robot was opened
        elif before is None or before.map is not document.map:
            self._ask()
