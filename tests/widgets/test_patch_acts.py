"""What is done to the selected patches: buttons, the menu over a row, method and slider, and long work."""

from __future__ import annotations

from functools import partial

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QLabel, QLineEdit, QMenu, QPushButton, QToolButton, QWidget

from app.editing.arrange import scale
from app.editing.document import MapDocument
from app.editing.reflatten import set_lengths, set_method
from app.maps.methods.table import METHODS
from tests.widgets.hand_made import leaf_map
from widgets.editor import Editor
from widgets.panels.column import WIDTH
from widgets.panels.panel import LabelledSlider
from widgets.panels.patch_list import ROW
from widgets.panels.patches_panel import PatchesPanel
from widgets.worker import InlineWorker, Worker

LEFT = Qt.MouseButton.LeftButton


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


def _click(panel, row):
    QTest.mouseClick(panel.list.viewport(), LEFT, Qt.KeyboardModifier.NoModifier, QPoint(100, row * ROW + ROW // 2))
    QApplication.processEvents()


def test_buttons_do_what_they_say_to_the_selected_patches(panel, editor):
    buttons = {name: panel.findChild(QPushButton, f"patch-{name}") for name in ("mirror", "align", "true-size", "pack")}
    assert [name for name, button in buttons.items() if button.isEnabled()] == ["pack"]
    editor.select([1])
    assert not buttons["align"].isEnabled(), "one patch has nothing to be aligned with"
    QTest.mouseClick(buttons["mirror"], LEFT)
    assert [p.mirrored for p in editor.document.layout.placements] == [False, True, False]
    editor.do("Scale", partial(scale, numbers=[1], factor=1.5))
    assert buttons["true-size"].isEnabled()
    QTest.mouseClick(buttons["true-size"], LEFT)
    assert editor.document.layout.placements[1].scale == 1
    assert not buttons["true-size"].isEnabled()
    editor.select([0, 1])
    menu = buttons["align"].menu()
    texts = [action.text() for action in menu.actions() if action.text()]
    assert texts == ["Left", "Centre", "Right", "Top", "Middle", "Bottom"]
    menu.actions()[0].trigger()
    lefts = editor.document.map.boxes[[0, 1], 0, 0]
    assert lefts[0] == pytest.approx(lefts[1])
    QTest.mouseClick(buttons["pack"], LEFT)
    assert editor.history.names[1:] == ("Mirror", "Scale", "True size", "Align left", "Pack again")


@pytest.mark.qt_log_ignore("does not support (raise|grabbing)", extend=True)
def test_the_menu_over_a_row_names_hides_and_shows(panel, editor):
    _click(panel, 1)
    panel.list.customContextMenuRequested.emit(QPoint(80, ROW + 4))
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


def test_a_method_is_chosen_by_a_plain_name(panel, editor):
    combo = panel.findChild(QComboBox, "patch-method")
    assert combo.count() == len(METHODS)
    assert all(len(combo.itemData(k, Qt.ItemDataRole.ToolTipRole)) > 10 for k in range(combo.count()))
    assert not combo.isEnabled()
    editor.select([2])
    assert combo.currentText() == "Balanced"
    combo.setCurrentIndex(combo.findData("tutte"))
    combo.activated.emit(combo.currentIndex())
    assert editor.document.patches[2].method == "tutte"
    assert editor.document.charts[2].method == "tutte"
    assert editor.history.names[-1] == "Method"
    assert "nothing but validity" in combo.toolTip()


def test_values_that_differ_are_a_dash(panel, editor):
    combo, slider = panel.findChild(QComboBox, "patch-method"), panel.findChild(LabelledSlider, "patch-lengths")
    editor.ask(partial(set_lengths, numbers=[2], lengths=0.5))
    editor.select([1, 2])
    assert combo.currentText() == "Balanced"
    assert [label.text() for label in slider.findChildren(QLabel)][-1] == "—"
    editor.ask(partial(set_method, numbers=[2], method="tutte"))
    assert combo.currentIndex() == -1
    assert combo.placeholderText() == "—"


def test_the_slider_acts_when_the_hand_lets_go(panel, editor, qtbot):
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


def test_a_method_without_a_slider_says_so(panel, editor):
    slider = panel.findChild(LabelledSlider, "patch-lengths")
    assert "Select a patch" in slider.toolTip()
    editor.ask(partial(set_method, numbers=[2], method="lscm"))
    editor.select([2])
    assert not slider.isEnabled()
    assert "Conformal (LSCM) keeps angles" in slider.toolTip()


def test_a_chart_from_elsewhere_keeps_its_own_name(qtbot):
    editor = Editor(InlineWorker())
    editor.open(MapDocument.of(leaf_map()))
    editor.set_enabled(enabled=True)
    panel = _shown(qtbot, PatchesPanel(editor))
    editor.select([0])
    combo = panel.findChild(QComboBox, "patch-method")
    assert combo.currentIndex() == -1
    assert combo.placeholderText() == "by hand"
    assert "made elsewhere" in panel.findChild(LabelledSlider, "patch-lengths").toolTip()


def test_long_work_is_told_and_cancelled(qtbot, prepared):
    worker = Worker()
    editor = Editor(worker)
    editor.open(MapDocument.of(prepared.map))
    editor.set_enabled(enabled=True)
    panel = _shown(qtbot, PatchesPanel(editor))
    line = panel.findChild(QWidget, "edit-progress")
    editor.ask(partial(set_method, numbers=[0, 1], method="tutte"))
    assert editor.busy
    assert not line.isVisible(), "nobody needs to be told what is done at once"
    qtbot.waitUntil(line.isVisible, timeout=5000)  # a fresh process starts slower than that
    QTest.mouseClick(panel.findChild(QToolButton, "edit-cancel"), LEFT)
    assert not editor.busy
    assert not line.isVisible()
    assert len(editor.history.names) == 1
    worker.close()
