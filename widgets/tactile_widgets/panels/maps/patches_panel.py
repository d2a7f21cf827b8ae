"""The patches panel: the list of patches, and what can be done to the selected ones.

``PatchActions`` are the actions (mirror, align, true size, pack, show, hide) as buttons and as a context menu;
``FlatteningControls`` choose the flattening method and the trade-off between angles and lengths; ``EditProgress`` says
what a worker computes for an edit, and cancels it.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from PySide6.QtCore import QObject, QPoint, Qt, QTimer, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QMenu,
    QProgressBar,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from tactile_maps.editing.arrange import EDGES, Edge, align, mirror, repack, true_size
from tactile_maps.editing.document import show_patches
from tactile_maps.editing.reflatten import set_lengths, set_method
from tactile_maps.flattening.methods import METHODS
from tactile_widgets.common.panel import MIXED_VALUES, LabelledSlider, Panel
from tactile_widgets.document.map_editor import Edit, MapEditor
from tactile_widgets.panels.maps.patch_list import PatchList, show_only

SHOW_AFTER_MS = 500
"""What is done sooner needs no telling."""
_TEXT_WIDTH = 100
"""For the words [px], until they are laid out."""


class EditProgress(QWidget):
    """There once an edit has taken half a second; its place is kept, so that nothing jumps under the pointer."""

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("edit-progress")
        self._text, self._bar, cancel = QLabel(self), QProgressBar(self), QToolButton(self)
        self._text.setProperty("role", "caption")
        self._text.setMinimumWidth(1)  # long words are cut before the panel is
        self._text.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self._bar.setRange(0, 1000)
        self._bar.setTextVisible(False)
        self._bar.setFixedSize(72, 6)
        self._bar.setAccessibleName("Progress")
        cancel.setText("Cancel")
        cancel.setObjectName("edit-cancel")
        cancel.setToolTip("Keep the current map")
        cancel.clicked.connect(editor.cancel_work)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(8)
        row.addWidget(self._text, 1)
        row.addWidget(self._bar, 0, Qt.AlignmentFlag.AlignVCenter)
        row.addWidget(cancel)
        self._patience = QTimer(self)
        self._patience.setSingleShot(True)
        self._patience.setInterval(SHOW_AFTER_MS)
        self._patience.timeout.connect(self.show)
        kept = self.sizePolicy()
        kept.setRetainSizeWhenHidden(True)
        self.setSizePolicy(kept)
        self.hide()
        editor.working.connect(self._on_working)
        editor.rested.connect(self._on_rested)

    def _on_working(self, text: str, fraction: float) -> None:
        metrics = self._text.fontMetrics()
        room = max(self._text.width(), _TEXT_WIDTH)
        self._text.setText(metrics.elidedText(text, Qt.TextElideMode.ElideRight, room))
        self._text.setToolTip(text)
        self._bar.setValue(round(1000 * fraction))
        if self.isHidden() and not self._patience.isActive():
            self._patience.start()

    def _on_rested(self) -> None:
        self._patience.stop()
        self.hide()


_EDGE_TIPS: dict[Edge, str] = {
    "left": "Move the patches so that their left edges are in line",
    "centre": "Move the patches so that their middles are above each other",
    "right": "Move the patches so that their right edges are in line",
    "top": "Move the patches so that their upper edges are in line",
    "middle": "Move the patches so that their middles are beside each other",
    "bottom": "Move the patches so that their lower edges are in line",
}


class PatchActions(QObject):
    """The actions, each enabled while it would do something.

    Args:
        editor: Whose selected patches.
        parent: Qt parent.

    Attributes:
        mirror: And likewise ``true_size``, ``pack``, ``show``, ``hide``, ``only`` and ``show_all``.
        align: One action an edge.
    """

    def __init__(self, editor: MapEditor, parent: QWidget) -> None:
        super().__init__(parent)
        self._editor = editor
        self.mirror = self._act("Mirror", "Mirror the selected patches horizontally", self._on_mirror)
        self.true_size = self._act("True size", "Draw the selected patches at their true size again", self._on_true)
        tip = "Arrange all patches, or those selected, as they sit on the body"
        self.pack = self._act("Repack", tip, self._on_pack)
        self.show = self._act("Show", "Show the selected patches", partial(self._on_show, visible=True))
        tip = "Hide the selected patches; hidden patches keep sensing"
        self.hide = self._act("Hide", tip, partial(self._on_show, visible=False))
        self.only = self._act("Show only these", "Hide all other patches", self._on_only)
        self.show_all = self._act("Show all", "Show every patch", self._on_show_all)
        self.align = [
            self._act(edge.capitalize(), _EDGE_TIPS[edge], partial(self._on_align, edge=edge)) for edge in EDGES
        ]
        for signal in (editor.settled, editor.selection_changed, editor.enabled_changed):
            signal.connect(self._update_state)
        self._update_state()

    def menu(self, parent: QWidget, first: Iterable[QAction] = ()) -> QMenu:
        """All of them, after ``first``."""
        menu = QMenu(parent)
        menu.setToolTipsVisible(True)
        menu.addActions([*first])
        menu.addSeparator()
        menu.addActions([self.show, self.hide, self.only, self.show_all])
        menu.addSeparator()
        menu.addAction(self.mirror)
        menu.addMenu(self.align_menu(menu)).setEnabled(self.align[0].isEnabled())
        menu.addActions([self.true_size, self.pack])
        return menu

    def align_menu(self, parent: QWidget) -> QMenu:
        """The six edges."""
        menu = QMenu("Align", parent)
        menu.setToolTipsVisible(True)
        menu.addActions(self.align[:3])
        menu.addSeparator()
        menu.addActions(self.align[3:])
        return menu

    def buttons(self, parent: QWidget) -> QWidget:
        """Mirror, Align, True size and Pack again, as two rows of equal buttons."""
        whole = QWidget(parent)
        grid = QGridLayout(whole)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setSpacing(4)
        align = QPushButton("Align", whole)
        align.setObjectName("patch-align")
        align.setToolTip("Move the selected patches into line; two at least")
        align.setMenu(self.align_menu(align))
        align.setEnabled(self.align[0].isEnabled())
        self.align[0].enabledChanged.connect(align.setEnabled)
        grid.addWidget(_button(self.mirror, "patch-mirror", whole), 0, 0)
        grid.addWidget(align, 0, 1)
        grid.addWidget(_button(self.true_size, "patch-true-size", whole), 1, 0)
        grid.addWidget(_button(self.pack, "patch-pack", whole), 1, 1)
        return whole

    def _act(self, text: str, tip: str, slot: object) -> QAction:
        action = QAction(text, self)
        action.setToolTip(tip)
        action.triggered.connect(slot)
        return action

    def _update_state(self) -> None:
        """Enable what would do something."""
        editor = self._editor
        document = editor.document
        chosen = editor.selected
        on = document is not None and editor.enabled
        patches = [] if document is None else document.patches
        scales = [] if document is None else [document.layout.placements[k].scale for k in chosen]
        for action in (self.mirror, self.only):
            action.setEnabled(on and bool(chosen))
        for action in self.align:
            action.setEnabled(on and len(chosen) > 1)
        self.true_size.setEnabled(on and any(scale != 1 for scale in scales))
        self.pack.setEnabled(on)
        self.show.setEnabled(on and any(not patches[k].visible for k in chosen))
        self.hide.setEnabled(on and any(patches[k].visible for k in chosen))
        self.show_all.setEnabled(on and not all(patch.visible for patch in patches))

    def _do(self, name: str, edit: Edit) -> None:
        self._editor.do(name, edit)

    def _on_mirror(self, _checked: bool = False) -> None:
        self._do("Mirror", partial(mirror, numbers=self._editor.selected))

    def _on_true(self, _checked: bool = False) -> None:
        self._do("True size", partial(true_size, numbers=self._editor.selected))

    def _on_pack(self, _checked: bool = False) -> None:
        self._do("Repack", partial(repack, numbers=self._editor.selected or None))

    def _on_align(self, _checked: bool = False, *, edge: Edge) -> None:
        self._do(f"Align {edge}", partial(align, numbers=self._editor.selected, edge=edge))

    def _on_show(self, _checked: bool = False, *, visible: bool) -> None:
        chosen = self._editor.selected
        self._do("Show patches" if visible else "Hide patches", partial(show_patches, numbers=chosen, visible=visible))

    def _on_only(self, _checked: bool = False) -> None:
        self._do("Show only these patches", partial(show_only, numbers=self._editor.selected))

    def _on_show_all(self, _checked: bool = False) -> None:
        if self._editor.document is not None:
            self._do("Show all patches", partial(show_patches, numbers=range(len(self._editor.document.patches))))


class _ActionButton(QPushButton):
    """A button for an action of the window, whose key in the tool tip may change."""

    def __init__(self, action: QAction, parent: QWidget) -> None:
        super().__init__(action.text(), parent)
        self._action = action
        self.clicked.connect(action.trigger)
        action.changed.connect(self._on_action_changed)
        self._on_action_changed()

    def _on_action_changed(self) -> None:
        self.setToolTip(self._action.toolTip())
        self.setEnabled(self._action.isEnabled())


def _button(action: QAction, name: str, parent: QWidget) -> QPushButton:
    button = _ActionButton(action, parent)
    button.setObjectName(name)
    return button


_METHOD_NAMES = {
    "symmetric-dirichlet": "Symmetric Dirichlet",
    "tutte": "Tutte",
    "harmonic": "Harmonic",
    "lscm": "Conformal (LSCM)",
    "arap": "As rigid as possible (ARAP)",
    "slim": "SLIM",
    "unroll": "Unroll",
}
_SLIDER_TIP = "Left preserves angles, right preserves lengths; the map is flattened again on release"


class FlatteningControls(QWidget):
    """Shows what is wanted of the selected patches, a dash where they differ, and asks the editor for something else.

    Args:
        editor: Whose patches.
        parent: Qt parent.
    """

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._method = QComboBox(self)
        self._method.setObjectName("patch-method")
        self._method.setAccessibleName("Method")
        for name in METHODS:
            self._method.addItem(_METHOD_NAMES.get(name, name), name)
            self._method.setItemData(self._method.count() - 1, _method_tip(name), Qt.ItemDataRole.ToolTipRole)
        self._method.activated.connect(self._on_method_chosen)
        label = QLabel("Method", self)
        label.setBuddy(self._method)
        self._lengths = LabelledSlider("Angle ↔ length preservation", "", 0.0, 1.0, 0.05, _SLIDER_TIP, self)
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
        column.addWidget(EditProgress(editor, self))
        editor.settled.connect(self._show)
        editor.selection_changed.connect(self._show)
        editor.rested.connect(self._show)  # refused or cancelled: the old values again
        editor.enabled_changed.connect(self._show)
        self._show()

    def _show(self) -> None:
        document = self._editor.document
        chosen = self._editor.selected
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
        why = _why_slider_disabled(methods)
        self._lengths.setEnabled(not why)
        self._lengths.set_tip(why or _SLIDER_TIP)

    def _show_method(self, methods: set[str]) -> None:
        name = next(iter(methods)) if len(methods) == 1 else ""
        self._method.setCurrentIndex(self._method.findData(name))
        self._method.setPlaceholderText(
            name or MIXED_VALUES
        )  # a chart from elsewhere has a method that is not in the table
        tip = _method_tip(name) if name in METHODS else "How the selected patches are flattened"
        self._method.setToolTip(tip if methods else "Select a patch to choose how it is flattened")

    def _on_method_chosen(self, index: int) -> None:
        self._editor.ask(partial(set_method, numbers=self._editor.selected, method=self._method.itemData(index)))
        if not self._editor.busy:
            self._show()

    def _on_lengths_rested(self, value: float) -> None:
        self._editor.ask(partial(set_lengths, numbers=self._editor.selected, lengths=round(value, 3)))
        if not self._editor.busy:
            self._show()


def _method_tip(name: str) -> str:
    """What a method keeps, as a sentence."""
    return f"Keeps {METHODS[name].title}"


def _why_slider_disabled(methods: Iterable[str]) -> str:
    """Why the slider does nothing; empty if it does."""
    names = list(methods)
    if not names:
        return "Select a patch to choose what its map preserves"
    for name in names:
        method = METHODS.get(name)
        if method is None:
            return f"This map was imported, method {name}; choose a method first"
        if not method.slides:
            return f"{_METHOD_NAMES.get(name, name)} preserves {method.title}; Symmetric Dirichlet has a slider"
    return ""


FILTER_FROM = 13
"""With so many patches a name is found by writing it sooner than by looking."""
_MARK = "▲"
_EMPTY = "Open a robot to arrange the patches of its map."
_REPLAYING = "A replay shows the map as it was; go back to live to edit it."


class PatchesPanel(Panel):
    """Names, order and visibility of the patches, buttons to arrange those selected, and how they are flattened.

    Args:
        editor: Whose document is shown and edited.
        parent: Qt parent.
    """

    hovered = Signal(object)
    """The number of the patch whose row is under the pointer, or None."""

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__("Patches", "patches-panel", parent)
        self._editor = editor
        self._note = self.caption(_EMPTY)
        self._note.setObjectName("patches-note")
        self._filter = QLineEdit(self)
        self._filter.setObjectName("patch-filter")
        self._filter.setAccessibleName("Find a patch or link")
        self._filter.setPlaceholderText("Find a patch or link")
        self._filter.setClearButtonEnabled(True)
        self.list = PatchList(editor, self)
        self._acts, self._wishes = PatchActions(editor, self), FlatteningControls(editor, self)
        self.column.addWidget(self._filter)
        self.column.addWidget(self.list)
        self._refusal = self.caption()
        self._refusal.setObjectName("name-refusal")
        self._refusal.hide()
        self._tools = self._acts.buttons(self)
        for part in (self._tools, self._wishes):
            self.column.addWidget(part)
        self._filter.textChanged.connect(self.list.patches.set_wanted)
        self.list.hovered.connect(self.hovered)
        self.list.patches.refused.connect(self._on_refused)
        self.list.customContextMenuRequested.connect(self._on_menu_requested)
        editor.settled.connect(self._update_state)
        editor.enabled_changed.connect(self._update_state)
        self._update_state()

    def show_hover(self, number: int | None) -> None:
        """Tint the row of the patch that the pointer is on in a view."""
        self.list.show_hover(number)

    def _update_state(self) -> None:
        """Empty, live, or shut while a recording is replayed."""
        document = self._editor.document
        count = 0 if document is None else len(document.patches)
        self._note.setText(_EMPTY if document is None else _REPLAYING)
        self._note.setHidden(document is not None and self._editor.enabled)
        self._filter.setVisible(count >= FILTER_FROM)
        if count < FILTER_FROM:
            self._filter.clear()
        for part in (self.list, self._tools, self._wishes):
            part.setEnabled(self._editor.enabled)
        for part in (self.list, self._tools, self._wishes):
            part.setHidden(document is None)
        if document is None:
            self._refusal.hide()

    def _on_refused(self, why: str) -> None:
        self._refusal.setText(f"{_MARK} {why[:1].upper()}{why[1:]}")
        self._refusal.setVisible(bool(why))

    def _on_menu_requested(self, at: QPoint) -> None:
        index = self.list.indexAt(at)
        rename = QAction("Rename", self)
        rename.setEnabled(index.isValid())
        rename.triggered.connect(self._on_rename)
        menu = self._acts.menu(self, [rename])
        menu.setObjectName("patch-menu")
        menu.aboutToHide.connect(menu.deleteLater)
        rename.setParent(menu)
        menu.popup(self.list.viewport().mapToGlobal(at))

    def _on_rename(self, _checked: bool = False) -> None:
        self.list.edit(self.list.currentIndex())
