"""What can be done to the selected patches at once: buttons, and the same in a menu over the patch tree."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from PySide6.QtCore import QObject
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QGridLayout, QMenu, QPushButton, QWidget

from app.editing.arrange import EDGES, Edge, align, mirror, repack, true_size
from app.editing.patches import show
from widgets.editor import Edit, Editor
from widgets.panels.patch_model import only

_EDGE_TIPS: dict[Edge, str] = {
    "left": "Move the patches so that their left edges are in line",
    "centre": "Move the patches so that their middles are above each other",
    "right": "Move the patches so that their right edges are in line",
    "top": "Move the patches so that their upper edges are in line",
    "middle": "Move the patches so that their middles are beside each other",
    "bottom": "Move the patches so that their lower edges are in line",
}


class PatchActs(QObject):
    """The actions, each enabled while it would do something.

    Args:
        editor: Whose selected patches.
        parent: Qt parent.

    Attributes:
        mirror: And likewise ``true_size``, ``pack``, ``show``, ``hide``, ``only`` and ``show_all``.
        align: One action an edge.
    """

    def __init__(self, editor: Editor, parent: QWidget) -> None:
        super().__init__(parent)
        self._editor = editor
        self.mirror = self._act("Mirror", "Exchange left and right of the selected patches", self._on_mirror)
        self.true_size = self._act("True size", "Draw the selected patches at their true size again", self._on_true)
        tip = "Arrange all patches, or those selected, as they sit on the body"
        self.pack = self._act("Pack again", tip, self._on_pack)
        self.show = self._act("Show", "Show the selected patches", partial(self._on_show, visible=True))
        tip = "Hide the selected patches; they feel and are controlled all the same"
        self.hide = self._act("Hide", tip, partial(self._on_show, visible=False))
        self.only = self._act("Show only these", "Hide all other patches", self._on_only)
        self.show_all = self._act("Show all", "Show every patch", self._on_show_all)
        self.align = [
            self._act(edge.capitalize(), _EDGE_TIPS[edge], partial(self._on_align, edge=edge)) for edge in EDGES
        ]
        for signal in (editor.settled, editor.selection_changed, editor.enabled_changed):
            signal.connect(self._dress)
        self._dress()

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

    def _dress(self) -> None:
        """Enable what would do something."""
        editor = self._editor
        document, chosen = editor.document, editor.selected
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
        self._do("Pack again", partial(repack, numbers=self._editor.selected or None))

    def _on_align(self, _checked: bool = False, *, edge: Edge) -> None:
        self._do(f"Align {edge}", partial(align, numbers=self._editor.selected, edge=edge))

    def _on_show(self, _checked: bool = False, *, visible: bool) -> None:
        chosen = self._editor.selected
        self._do("Show patches" if visible else "Hide patches", partial(show, numbers=chosen, visible=visible))

    def _on_only(self, _checked: bool = False) -> None:
        self._do("Show only these patches", partial(only, numbers=self._editor.selected))

    def _on_show_all(self, _checked: bool = False) -> None:
        if self._editor.document is not None:
            self._do("Show all patches", partial(show, numbers=range(len(self._editor.document.patches))))


def _button(action: QAction, name: str, parent: QWidget) -> QPushButton:
    button = QPushButton(action.text(), parent)
    button.setObjectName(name)
    button.setToolTip(action.toolTip())
    button.setEnabled(action.isEnabled())
    button.clicked.connect(action.trigger)
    action.enabledChanged.connect(button.setEnabled)
    return button
