"""The patch tree: every act is an edit of the document, and every edit is seen in the tree."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import pytest
from PySide6.QtCore import QEvent, QMimeData, QPoint, QPointF, Qt
from PySide6.QtGui import QDragEnterEvent, QDragMoveEvent, QDropEvent, QShortcut
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QLineEdit

from app.editing.document import MapDocument
from app.editing.patches import rename, show
from app.editing.pins import add_pin
from app.maps.layout import MapLayout, Placement
from app.maps.tactile_map import TactileMap
from app.skin.skin import Skin
from tests.widgets.hand_made import leaf_map
from widgets.editor import Editor
from widgets.panels.column import WIDTH
from widgets.panels.patch_list import ROW
from widgets.panels.patch_model import MIME, PINS, SEAMS
from widgets.panels.patches_panel import FILTER_FROM, PatchesPanel
from widgets.worker import InlineWorker

LEFT, NONE, ALT = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.AltModifier
CTRL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def panel(qtbot, editor):
    return _shown(qtbot, PatchesPanel(editor))


def _shown(qtbot, panel):
    qtbot.addWidget(panel)
    panel.resize(WIDTH, 500)
    panel.show()
    qtbot.waitExposed(panel)
    QApplication.processEvents()
    return panel


def _names(panel):
    model = panel.list.patches
    return [model.index(row).data() for row in range(model.rowCount())]


def _click(panel, row, *, x=100, keys=NONE, double=False):
    at = QPoint(x, row * ROW + ROW // 2)
    QTest.mouseClick(panel.list.viewport(), LEFT, keys, at)
    if double:
        QTest.mouseDClick(panel.list.viewport(), LEFT, keys, at)
    QApplication.processEvents()


def _field(panel):
    field = panel.list.findChild(QLineEdit, "patch-name")
    assert field is not None, "the name is not being written"
    return field


def _text(panel, name):
    label = panel.findChild(QLabel, name)
    return label.text() if label.isVisible() else ""


def test_a_row_a_patch_in_the_order_of_the_tree(panel, editor):
    assert _names(panel) == [patch.name for patch in editor.document.patches]
    assert panel.list.height() == 3 * ROW
    assert panel.minimumSizeHint().width() <= WIDTH - 8, "a scroll bar must fit beside it"


@pytest.mark.parametrize("by", ["double click", "F2"])
def test_a_name_is_written_in_its_place(panel, editor, by):
    steals = QShortcut(Qt.Key.Key_F2, panel)
    fired = []
    steals.activated.connect(lambda: fired.append(1))
    _click(panel, 1, double=by != "F2")
    if by == "F2":
        panel.list.setFocus()
        QTest.keyClick(panel.list, Qt.Key.Key_F2)
    QTest.keyClicks(_field(panel), "Elbow")
    QTest.keyClick(_field(panel), Qt.Key.Key_Return)
    QApplication.processEvents()  # the field takes the key before its words are taken
    assert editor.document.patches[1].name == "Elbow"
    assert editor.history.names[-1] == "Rename a patch"
    assert _names(panel)[1] == "Elbow"
    assert not fired, "the window's own F2 must not act while a patch has the focus"


def test_a_refused_name_stays_open_and_says_why(panel, editor):
    taken = editor.document.patches[0].name
    _click(panel, 1, double=True)
    field = _field(panel)
    field.setText(taken)
    QTest.keyClick(field, Qt.Key.Key_Return)
    QApplication.processEvents()
    assert _field(panel) is field
    assert "Another patch has this name" in _text(panel, "name-refusal")
    assert len(editor.history.names) == 1
    field.setText("Elbow")
    QTest.keyClick(field, Qt.Key.Key_Return)
    QApplication.processEvents()
    assert editor.document.patches[1].name == "Elbow"
    assert _text(panel, "name-refusal") == ""


def test_escape_leaves_the_name(panel, editor):
    _click(panel, 1, double=True)
    before = _names(panel)
    QTest.keyClicks(_field(panel), "Elbow")
    QTest.keyClick(_field(panel), Qt.Key.Key_Escape)
    assert _names(panel) == before
    assert len(editor.history.names) == 1


def test_the_eye_hides_and_shows_and_selects_nothing(panel, editor):
    _click(panel, 1, x=10)
    assert [patch.visible for patch in editor.document.patches] == [True, False, True]
    assert editor.history.names[-1] == f"Hide {editor.document.patches[1].name}"
    assert editor.selected == ()
    _click(panel, 1, x=10)
    assert all(patch.visible for patch in editor.document.patches)


def test_alt_and_the_eye_shows_only_this_one_and_then_all(panel, editor):
    _click(panel, 2, x=10, keys=ALT)
    assert [patch.visible for patch in editor.document.patches] == [False, False, True]
    assert len(editor.history.names) == 2, "one act, one step"
    _click(panel, 2, x=10, keys=ALT)
    assert all(patch.visible for patch in editor.document.patches)


def test_two_quick_presses_on_the_eye_are_two(panel, editor):
    _click(panel, 0, x=10, double=True)
    assert editor.document.patches[0].visible
    assert len(editor.history.names) == 3
    assert panel.list.findChild(QLineEdit, "patch-name") is None


def test_selection_goes_both_ways(panel, editor):
    _click(panel, 0)
    assert editor.selected == (0,)
    _click(panel, 2, keys=CTRL)
    assert editor.selected == (0, 2)
    _click(panel, 1)
    _click(panel, 2, keys=SHIFT)
    assert editor.selected == (1, 2)
    editor.select([0])
    assert [index.row() for index in panel.list.selectedIndexes()] == [0]
    assert editor.selected == (0,)


def test_the_selection_stays_with_its_patches_when_the_order_changes(panel, editor):
    editor.select([2])
    panel.list.patches.move([2], 0)
    assert editor.document.order == (2, 0, 1)
    assert editor.selected == (2,)
    assert [index.row() for index in panel.list.selectedIndexes()] == [0]


@pytest.mark.parametrize(
    ("rows", "y", "order"),
    [
        ([2], 2, (2, 0, 1)),
        ([0], 3 * ROW - 2, (1, 2, 0)),
        ([0, 1], 3 * ROW - 2, (2, 0, 1)),
        ([0], 3 * ROW + 40, (1, 2, 0)),
    ],
)
def test_rows_are_dragged_to_another_place(panel, editor, rows, y, order):
    model = panel.list.patches
    data = model.mimeData([model.index(row) for row in rows])
    assert data.hasFormat(MIME)
    panel.list.setFixedHeight(200)
    view, at = panel.list.viewport(), QPoint(80, y)
    where = (data, LEFT, NONE)
    QApplication.sendEvent(view, QDragEnterEvent(at, Qt.DropAction.MoveAction, *where))
    QApplication.sendEvent(view, QDragMoveEvent(at, Qt.DropAction.MoveAction, *where))
    drop = QDropEvent(QPointF(at), Qt.DropAction.MoveAction, *where)
    QApplication.sendEvent(view, drop)
    assert editor.document.order == order
    assert _names(panel) == [editor.document.patches[k].name for k in order]
    assert editor.history.names[1:] == ("Reorder patches",)


def test_what_is_no_patch_is_not_dropped(panel, editor):
    data = QMimeData()
    data.setText("0 1")
    drop = QDropEvent(QPointF(80, 4), Qt.DropAction.MoveAction, data, LEFT, NONE)
    QApplication.sendEvent(panel.list.viewport(), drop)
    assert len(editor.history.names) == 1


def test_alt_and_the_arrows_move_rows(panel, editor):
    _click(panel, 0)
    panel.list.setFocus()
    QTest.keyClick(panel.list, Qt.Key.Key_Down, ALT)
    assert editor.document.order == (1, 0, 2)
    QTest.keyClick(panel.list, Qt.Key.Key_Down, ALT)
    QTest.keyClick(panel.list, Qt.Key.Key_Down, ALT)
    assert editor.document.order == (1, 2, 0)
    QTest.keyClick(panel.list, Qt.Key.Key_Up, ALT)
    assert editor.document.order == (1, 0, 2)


def test_the_pointer_on_a_row_tells_the_views(panel):
    told = []
    panel.hovered.connect(told.append)
    view = panel.list.viewport()
    for row in (0, 2):
        QTest.mouseMove(view, QPoint(80, row * ROW + 10))
        QApplication.processEvents()
    QApplication.sendEvent(panel.list, QEvent(QEvent.Type.Leave))
    assert told == [0, 2, None]


def test_pins_and_seams_are_told(panel, editor, prepared):
    index = panel.list.patches.index(0)
    assert bool(index.data(SEAMS)) == bool(len(prepared.map.charts[0].seams))
    editor.do("Add a pin", partial(add_pin, at=prepared.skin.taxel_point(3)))
    assert index.data(PINS) == 1
    assert "1 pin\n" in index.data(Qt.ItemDataRole.ToolTipRole)
    editor.do("Hide", partial(show, numbers=[0], visible=False))
    assert "hidden" in index.data(Qt.ItemDataRole.AccessibleTextRole)


def test_many_patches_have_a_filter(qtbot, editor, panel):
    assert not panel.findChild(QLineEdit, "patch-filter").isVisible()
    many = _document_of(FILTER_FROM)
    editor.open(many)
    QApplication.processEvents()
    field = panel.findChild(QLineEdit, "patch-filter")
    assert field.isVisible()
    editor.select([0, 5])
    QTest.keyClicks(field, "leaf 05")
    assert _names(panel) == ["leaf 05"]
    assert editor.selected == (0, 5), "what is filtered out is still selected"
    panel.list.patches.move([5], 0)
    assert editor.document.order == many.order, "alone in sight it has nowhere to go"
    field.clear()
    assert len(_names(panel)) == FILTER_FROM
    assert panel.list.height() < FILTER_FROM * ROW, "a long tree scrolls"


def _document_of(count):
    """A document of so many leaves."""
    leaf = leaf_map()
    patches = tuple(replace(leaf.skin.patches[0], name=f"leaf {k:02d}") for k in range(count))
    layout = MapLayout(tuple(Placement(offset=(0.3 * k, 0.0)) for k in range(count)))
    return MapDocument.of(TactileMap(Skin(patches), (leaf.charts[0],) * count, layout))


def test_empty_and_replaying_say_what_to_do(qtbot, prepared):
    editor = Editor(InlineWorker())
    panel = _shown(qtbot, PatchesPanel(editor))
    assert "Open a robot" in _text(panel, "patches-note")
    assert not panel.list.isVisible()
    editor.open(MapDocument.of(prepared.map))
    assert "go back to live" in _text(panel, "patches-note")
    assert panel.list.isVisible()
    _click(panel, 0, x=10)
    assert editor.document.patches[0].visible
    editor.set_enabled(enabled=True)
    assert _text(panel, "patches-note") == ""


def test_edits_made_elsewhere_are_seen(panel, editor):
    editor.do("Rename", partial(rename, number=0, name="Biceps"))
    assert _names(panel)[0] == "Biceps"
    editor.undo()
    assert _names(panel)[0] != "Biceps"
