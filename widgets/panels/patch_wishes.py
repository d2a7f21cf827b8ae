"""How the selected patches are laid flat: the method, and the slider between angles and lengths."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from app.editing.reflatten import set_lengths, set_method
from app.maps.methods.table import METHODS
from widgets.editor import Editor
from widgets.panels.busy_line import BusyLine
from widgets.panels.panel import MIXED, LabelledSlider

_NAMES = {
    "symmetric-dirichlet": "Balanced",
    "tutte": "Tutte",
    "harmonic": "Harmonic",
    "lscm": "Conformal (LSCM)",
    "arap": "As rigid as possible",
    "slim": "SLIM",
    "unroll": "Unroll",
}
_SLIDER_TIP = "Further left keeps shapes, further right keeps sizes; the map is laid flat anew when you let go"


class PatchWishes(QWidget):
    """Shows what is wanted of the selected patches, a dash where they differ, and asks the editor for something else.

    Args:
        editor: Whose patches.
        parent: Qt parent.
    """

    def __init__(self, editor: Editor, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._method = QComboBox(self)
        self._method.setObjectName("patch-method")
        self._method.setAccessibleName("Method")
        for name in METHODS:
            self._method.addItem(_NAMES.get(name, name), name)
            self._method.setItemData(self._method.count() - 1, _kept(name), Qt.ItemDataRole.ToolTipRole)
        self._method.activated.connect(self._on_method_chosen)
        label = QLabel("Method", self)
        label.setBuddy(self._method)
        self._lengths = LabelledSlider("Angles ↔ lengths", "", 0.0, 1.0, 0.05, _SLIDER_TIP, self)
        self._lengths.setObjectName("patch-lengths")
        self._lengths.rested.connect(self._on_lengths_rested)
        row = QHBoxLayout()
        row.setSpacing(8)
        row.addWidget(label)
        row.addWidget(self._method, 1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(8)
        column.addLayout(row)
        column.addWidget(self._lengths)
        column.addWidget(BusyLine(editor, self))
        editor.settled.connect(self._show)
        editor.selection_changed.connect(self._show)
        editor.rested.connect(self._show)  # refused or cancelled: the old values again
        editor.enabled_changed.connect(self._show)
        self._show()

    def _show(self) -> None:
        document, chosen = self._editor.document, self._editor.selected
        patches = [] if document is None else [document.patches[k] for k in chosen]
        self._method.setEnabled(bool(patches))
        methods = {patch.method for patch in patches}
        self._show_method(methods)
        lengths = {patch.lengths for patch in patches}
        if not self._lengths.held:
            if len(lengths) == 1:
                self._lengths.set_value(lengths.pop())
            else:
                self._lengths.set_mixed()
        why = _no_slider(methods)
        self._lengths.setEnabled(not why)
        self._lengths.set_tip(why or _SLIDER_TIP)

    def _show_method(self, methods: set[str]) -> None:
        name = next(iter(methods)) if len(methods) == 1 else ""
        self._method.setCurrentIndex(self._method.findData(name))
        self._method.setPlaceholderText(name or MIXED)  # a chart from elsewhere has a method that is not in the table
        tip = _kept(name) if name in METHODS else "How the selected patches are laid flat"
        self._method.setToolTip(tip if methods else "Select a patch to choose how it is laid flat")

    def _on_method_chosen(self, index: int) -> None:
        self._editor.ask(partial(set_method, numbers=self._editor.selected, method=self._method.itemData(index)))
        if not self._editor.busy:
            self._show()

    def _on_lengths_rested(self, value: float) -> None:
        self._editor.ask(partial(set_lengths, numbers=self._editor.selected, lengths=round(value, 3)))
        if not self._editor.busy:
            self._show()


def _kept(name: str) -> str:
    """What a method keeps, as a sentence."""
    return f"Keeps {METHODS[name].title}"


def _no_slider(methods: Iterable[str]) -> str:
    """Why the slider does nothing; empty if it does."""
    names = list(methods)
    if not names:
        return "Select a patch to choose what its map keeps"
    for name in names:
        method = METHODS.get(name)
        if method is None:
            return f"This map was made elsewhere, by {name}; choose a method first"
        if not method.slides:
            return f"{_NAMES.get(name, name)} keeps {method.title}, whatever the slider; Balanced has one"
    return ""
