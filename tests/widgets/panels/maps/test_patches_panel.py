"""The patches panel: every act edits the document, every edit is seen in the list; actions, method and slider."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import pytest
from PySide6.QtCore import QEvent, QMimeData, QPoint, QPointF, Qt
from PySide6.QtGui import QDragEnterEvent, QDragMoveEvent, QDropEvent, QShortcut
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QLabel, QLineEdit, QMenu, QPushButton, QToolButton, QWidget

from tactile_maps.editing.arrange import scale
from tactile_maps.editing.document import MapDocument, rename_patch, show_patches
from tactile_maps.editing.pins import add_pin
from tactile_maps.editing.reflatten import set_lengths, set_method
from tactile_maps.flattening.methods import METHODS
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.panel import LabelledSlider
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.jobs.executor import InlineExecutor, ProcessExecutor
from tactile_widgets.jobs.scene_jobs import SceneJobs
from tactile_widgets.panels.maps.patch_list import PATCHES_MIME, PINS_ROLE, ROW_HEIGHT, SEAMS_ROLE
from tactile_widgets.panels.maps.patches_panel import FILTER_FROM, PatchesPanel
from tactile_widgets.panels.panel_column import COLUMN_WIDTH
from tests.widgets.support.mouse import left_click
from tests.widgets.support.samples import leaf_map

LEFT = Qt.MouseButton.LeftButton
NONE = Qt.KeyboardModifier.NoModifier
ALT = Qt.KeyboardModifier.AltModifier
CTRL = Qt.KeyboardModifier.ControlModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def panel(qtbot, editor):
    return _shown(qtbot, PatchesPanel(editor))


def _shown(qtbot, panel):
    qtbot.addWidget(panel)
    panel.resize(COLUMN_WIDTH, 500)
    panel.show()
    qtbot.waitExposed(panel)
    QApplication.processEvents()
    return panel


def _names(panel):
    model = panel.list.patches
    return [model.index(row).data() for row in range(model.rowCount())]


def _click(panel, row, *, x=100, keys=NONE, double=False):
    at = QPoint(x, row * ROW_HEIGHT + ROW_HEIGHT // 2)
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


def test_patches_have_rows_in_the_order_of_the_tree(panel, editor):
    assert _names(panel) == [patch.name for patch in editor.document.patches]
    assert panel.list.height() == 3 * ROW_HEIGHT
    assert panel.minimumSizeHint().width() <= COLUMN_WIDTH - 8, "a scroll bar must fit next to it"


@pytest.mark.parametrize("by", ["double click", "F2"])
def test_name_is_edited_in_its_row(panel, editor, by):
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


def test_rejected_name_stays_open_with_the_reason(panel, editor):
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


def test_escape_cancels_the_edit_of_a_name(panel, editor):
    _click(panel, 1, double=True)
    before = _names(panel)
    QTest.keyClicks(_field(panel), "Elbow")
    QTest.keyClick(_field(panel), Qt.Key.Key_Escape)
    assert _names(panel) == before
    assert len(editor.history.names) == 1


def test_eye_button_toggles_visibility_without_selecting(panel, editor):
    _click(panel, 1, x=10)
    assert [patch.visible for patch in editor.document.patches] == [True, False, True]
    assert editor.history.names[-1] == f"Hide {editor.document.patches[1].name}"
    assert editor.selected == ()
    _click(panel, 1, x=10)
    assert all(patch.visible for patch in editor.document.patches)


def test_alt_click_on_the_eye_shows_only_this_patch_and_then_all(panel, editor):
    _click(panel, 2, x=10, keys=ALT)
    assert [patch.visible for patch in editor.document.patches] == [False, False, True]
    assert len(editor.history.names) == 2, "one act, one step"
    _click(panel, 2, x=10, keys=ALT)
    assert all(patch.visible for patch in editor.document.patches)


def test_two_quick_clicks_on_the_eye_are_two_toggles(panel, editor):
    _click(panel, 0, x=10, double=True)
    assert editor.document.patches[0].visible
    assert len(editor.history.names) == 3
    assert panel.list.findChild(QLineEdit, "patch-name") is None


def test_selection_is_synchronised_both_ways(panel, editor):
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


def test_selection_follows_its_patches_when_the_order_changes(panel, editor):
    editor.select([2])
    panel.list.patches.move([2], 0)
    assert editor.document.order == (2, 0, 1)
    assert editor.selected == (2,)
    assert [index.row() for index in panel.list.selectedIndexes()] == [0]


@pytest.mark.parametrize(
    ("rows", "y", "order"),
    [
        ([2], 2, (2, 0, 1)),
        ([0], 3 * ROW_HEIGHT - 2, (1, 2, 0)),
        ([0, 1], 3 * ROW_HEIGHT - 2, (2, 0, 1)),
        ([0], 3 * ROW_HEIGHT + 40, (1, 2, 0)),
    ],
)
def test_rows_are_dragged_to_another_place(panel, editor, rows, y, order):
    model = panel.list.patches
    data = model.mimeData([model.index(row) for row in rows])
    assert data.hasFormat(PATCHES_MIME)
    panel.list.setFixedHeight(200)
    view = panel.list.viewport()
    at = QPoint(80, y)
    where = (data, LEFT, NONE)
    QApplication.sendEvent(view, QDragEnterEvent(at, Qt.DropAction.MoveAction, *where))
    QApplication.sendEvent(view, QDragMoveEvent(at, Qt.DropAction.MoveAction, *where))
    drop = QDropEvent(QPointF(at), Qt.DropAction.MoveAction, *where)
    QApplication.sendEvent(view, drop)
    assert editor.document.order == order
    assert _names(panel) == [editor.document.patches[k].name for k in order]
    assert editor.history.names[1:] == ("Reorder patches",)


def test_only_patches_can_be_dropped(panel, editor):
    data = QMimeData()
    data.setText("0 1")
    drop = QDropEvent(QPointF(80, 4), Qt.DropAction.MoveAction, data, LEFT, NONE)
    QApplication.sendEvent(panel.list.viewport(), drop)
    assert len(editor.history.names) == 1


def test_alt_and_arrow_keys_move_rows(panel, editor):
    _click(panel, 0)
    panel.list.setFocus()
    QTest.keyClick(panel.list, Qt.Key.Key_Down, ALT)
    assert editor.document.order == (1, 0, 2)
    QTest.keyClick(panel.list, Qt.Key.Key_Down, ALT)
    QTest.keyClick(panel.list, Qt.Key.Key_Down, ALT)
    assert editor.document.order == (1, 2, 0)
    QTest.keyClick(panel.list, Qt.Key.Key_Up, ALT)
    assert editor.document.order == (1, 0, 2)
    panel.list.clearSelection()
    QTest.keyClick(panel.list, Qt.Key.Key_Up, ALT)
    assert editor.document.order == (1, 0, 2)


def test_hovered_row_is_reported_to_the_views(panel):
    hovered = []
    panel.hovered.connect(hovered.append)
    view = panel.list.viewport()
    for row in (0, 2):
        QTest.mouseMove(view, QPoint(80, row * ROW_HEIGHT + 10))
        QApplication.processEvents()
    QApplication.sendEvent(panel.list, QEvent(QEvent.Type.Leave))
    assert hovered == [0, 2, None]


def test_pins_and_seams_are_shown(panel, editor, prepared):
    index = panel.list.patches.index(0)
    assert bool(index.data(SEAMS_ROLE)) == bool(len(prepared.map.charts[0].seams))
    editor.do("Add a pin", partial(add_pin, at=prepared.skin.taxel_point(3)))
    assert index.data(PINS_ROLE) == 1
    assert "1 pin\n" in index.data(Qt.ItemDataRole.ToolTipRole)
    editor.do("Hide", partial(show_patches, numbers=[0], visible=False))
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
    assert panel.list.height() < FILTER_FROM * ROW_HEIGHT, "a long tree scrolls"


def _document_of(count):
    """A document of so many leaves."""
    leaf = leaf_map()
    patches = tuple(replace(leaf.skin.patches[0], name=f"leaf {k:02d}") for k in range(count))
    layout = MapLayout(tuple(Placement(offset=(0.3 * k, 0.0)) for k in range(count)))
    return MapDocument.of(TactileMap(Skin(patches), (leaf.charts[0],) * count, layout))


def test_empty_panel_and_replay_show_an_explanation(qtbot, prepared):
    editor = MapEditor(SceneJobs(InlineExecutor("prepare")))
    panel = _shown(qtbot, PatchesPanel(editor))
    assert "Open a robot" in _text(panel, "patches-note")
    assert not panel.list.isVisible()
    editor.open(MapDocument.of(prepared.map))
    assert "return to the session" in _text(panel, "patches-note")
    assert panel.list.isVisible()
    _click(panel, 0, x=10)
    assert editor.document.patches[0].visible
    editor.set_enabled(enabled=True)
    assert _text(panel, "patches-note") == ""


def test_edits_made_elsewhere_are_shown(panel, editor):
    editor.do("Rename", partial(rename_patch, number=0, name="Biceps"))
    assert _names(panel)[0] == "Biceps"
    editor.undo()
    assert _names(panel)[0] != "Biceps"


def _click_row(panel, row):
    left_click(panel.list.viewport(), QPoint(100, row * ROW_HEIGHT + ROW_HEIGHT // 2))
    QApplication.processEvents()


def test_buttons_act_on_the_selected_patches(panel, editor):
    buttons = {name: panel.findChild(QPushButton, f"patch-{name}") for name in ("mirror", "align", "true-size", "pack")}
    assert [name for name, button in buttons.items() if button.isEnabled()] == ["pack"]
    editor.select([1])
    assert not buttons["align"].isEnabled(), "aligning needs two patches"
    left_click(buttons["mirror"])
    assert [p.mirrored for p in editor.document.layout.placements] == [False, True, False]
    editor.do("Scale", partial(scale, numbers=[1], factor=1.5))
    assert buttons["true-size"].isEnabled()
    left_click(buttons["true-size"])
    assert editor.document.layout.placements[1].scale == 1
    assert not buttons["true-size"].isEnabled()
    editor.select([0, 1])
    menu = buttons["align"].menu()
    texts = [action.text() for action in menu.actions() if action.text()]
    assert texts == ["Left", "Centre", "Right", "Top", "Middle", "Bottom"]
    menu.actions()[0].trigger()
    lefts = editor.document.map.boxes[[0, 1], 0, 0]
    assert lefts[0] == pytest.approx(lefts[1])
    left_click(buttons["pack"])
    assert editor.history.names[1:] == ("Mirror", "Scale", "True size", "Align left", "Repack")


@pytest.mark.qt_log_ignore("does not support (raise|grabbing)", extend=True)
def test_row_menu_renames_hides_and_shows_patches(panel, editor):
    _click_row(panel, 1)
    panel.list.customContextMenuRequested.emit(QPoint(80, ROW_HEIGHT + 4))
    menu = panel.findChild(QMenu, "patch-menu")
    acts = {action.text(): action for action in menu.actions()}
    assert not acts["Show"].isEnabled()
    acts["Hide"].trigger()
    assert not editor.document.patches[1].visible
    acts["Show all"].trigger()
    assert editor.document.patches[1].visible
    acts["Show only these"].trigger()
    assert [patch.visible for patch in editor.document.patches] == [False, True, False]
    acts["Rename"].trigger()
    field = panel.list.findChild(QLineEdit, "patch-name")
    assert field.text() == editor.document.patches[1].name
    menu.close()
    QTest.keyClick(field, Qt.Key.Key_Escape)


def test_method_is_chosen_by_its_display_name(panel, editor):
    combo = panel.findChild(QComboBox, "patch-method")
    assert combo.count() == len(METHODS)
    assert all(len(combo.itemData(k, Qt.ItemDataRole.ToolTipRole)) > 10 for k in range(combo.count()))
    assert not combo.isEnabled()
    editor.select([2])
    assert combo.currentText() == "Symmetric Dirichlet"
    combo.setCurrentIndex(combo.findData("tutte"))
    combo.activated.emit(combo.currentIndex())
    assert editor.document.patches[2].method == "tutte"
    assert editor.document.charts[2].method == "tutte"
    assert editor.history.names[-1] == "Method"
    assert "nothing but validity" in combo.toolTip()


def test_differing_values_are_shown_as_a_dash(panel, editor):
    combo = panel.findChild(QComboBox, "patch-method")
    slider = panel.findChild(LabelledSlider, "patch-lengths")
    editor.ask(partial(set_lengths, numbers=[2], lengths=0.5))
    editor.select([1, 2])
    assert combo.currentText() == "Symmetric Dirichlet"
    assert slider._value.text() == "—"
    editor.ask(partial(set_method, numbers=[2], method="tutte"))
    assert combo.currentIndex() == -1
    assert combo.placeholderText() == "—"


def test_slider_takes_effect_when_released(panel, editor, qtbot):
    slider = panel.findChild(LabelledSlider, "patch-lengths")
    assert not slider.isEnabled()
    editor.select([2])
    assert slider.isEnabled()
    handle = slider._slider
    handle.setSliderDown(True)
    handle.setValue(handle.maximum() // 2)
    handle.setValue(handle.maximum() // 4)
    assert editor.document.patches[2].lengths == 1.0, "the hand still has it"
    handle.setSliderDown(False)
    assert editor.document.patches[2].lengths == pytest.approx(0.25)
    assert editor.history.names[1:] == ("Angles and lengths",)
    QTest.keyClick(handle, Qt.Key.Key_Right)
    QTest.keyClick(handle, Qt.Key.Key_Right)
    qtbot.waitUntil(lambda: editor.document.patches[2].lengths == pytest.approx(0.35))
    assert len(editor.history.names) == 3, "keys that come quickly are one step"


def test_method_without_a_slider_is_indicated(panel, editor):
    slider = panel.findChild(LabelledSlider, "patch-lengths")
    assert "Select a patch" in slider.toolTip()
    editor.ask(partial(set_method, numbers=[2], method="lscm"))
    editor.select([2])
    assert not slider.isEnabled()
    assert "Conformal (LSCM) preserves angles" in slider.toolTip()


def test_imported_chart_keeps_its_method_name(qtbot):
    editor = MapEditor(SceneJobs(InlineExecutor("prepare")))
    editor.open(MapDocument.of(leaf_map()))
    editor.set_enabled(enabled=True)
    panel = _shown(qtbot, PatchesPanel(editor))
    editor.select([0])
    combo = panel.findChild(QComboBox, "patch-method")
    assert combo.currentIndex() == -1
    assert combo.placeholderText() == "by hand"
    assert "was imported" in panel.findChild(LabelledSlider, "patch-lengths").toolTip()


@pytest.mark.long
def test_long_computation_shows_progress_and_can_be_cancelled(qtbot, prepared):
    worker = SceneJobs(ProcessExecutor("prepare"))
    editor = MapEditor(worker)
    editor.open(MapDocument.of(prepared.map))
    editor.set_enabled(enabled=True)
    panel = _shown(qtbot, PatchesPanel(editor))
    line = panel.findChild(QWidget, "edit-progress")
    editor.ask(partial(set_method, numbers=[0, 1], method="tutte"))
    assert editor.busy
    assert not line.isVisible(), "short work shows no progress"
    qtbot.waitUntil(line.isVisible)  # a fresh process starts slower than that
    left_click(panel.findChild(QToolButton, "edit-cancel"))
    assert not editor.busy
    assert not line.isVisible()
    assert len(editor.history.names) == 1
    worker.close()
