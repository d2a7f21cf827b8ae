"""Comparing with another layout: what can be B, what is refused, when it is measured, seen and taken over."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication, QLabel, QPushButton

from tactile_maps.editing.arrange import mirror, move
from tactile_maps.editing.document import MapDocument, rename_patch
from tactile_maps.editing.document_file import save_document
from tactile_maps.editing.pins import pin_places
from tactile_maps.editing.reflatten import set_method
from tactile_maps.maps.evaluation.comparison import TaxelLayout, compare_maps, procrustes
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.skin.formats.taxel_files import write_taxels
from tactile_widgets.panels.maps.compare_panel import ComparePanel
from tactile_widgets.panels.panel_column import COLUMN_WIDTH, PanelColumn
from tests.widgets.support.mouse import left_click
from tests.widgets.support.samples import leaf_map


@pytest.fixture
def panel(qtbot, editor):
    made = ComparePanel(editor)
    qtbot.addWidget(made)
    made.resize(COLUMN_WIDTH, 300)
    made.show()
    qtbot.waitExposed(made)
    made.asked = []
    made.shown = []
    made.compare_requested.connect(lambda first, second: made.asked.append((first, second)))
    made.shown_other.connect(made.shown.append)
    return made


def _button(panel, name):
    return panel.findChild(QPushButton, f"compare-{name}")


def _press(panel, name):
    assert _button(panel, name).isVisible()
    left_click(_button(panel, name))
    QApplication.processEvents()


def _note(panel):
    label = panel.findChild(QLabel, "compare-note")
    return label.text() if label.isVisible() else ""


@pytest.fixture
def drawing(tmp_path, editor):
    """File with the map's taxels drawn by hand: another size, turned, and bent."""
    x, y = editor.document.map.taxel_points.T
    points = 0.4 * np.stack([y + 0.3 * x**2, -x], axis=1)
    path = tmp_path / "by hand.csv"
    write_taxels(editor.document.skin, path, points=points)
    return path, points


def test_empty_panel_explains_what_can_be_compared(panel):
    assert "another map" in _note(panel)
    assert _button(panel, "with").isEnabled()
    assert not any(_button(panel, name).isVisible() for name in ("a", "b", "take", "forget"))


def test_current_map_can_be_kept_for_comparison(panel, editor):
    before = editor.document
    _press(panel, "keep")
    assert panel.other is before
    assert panel.asked == [(before.map, before.map)]
    assert "Measuring" in _note(panel)
    editor.do("Move", partial(move, numbers=[0], by=(0.05, 0.0)))
    assert panel.asked[1:] == [(editor.document.map, before.map)]
    editor.do("Rename", partial(rename_patch, number=0, name="Biceps"))
    assert len(panel.asked) == 2, "a name changes no number"
    _press(panel, "keep")
    assert _button(panel, "b").accessibleName() == "B: after Rename"


def test_edit_while_map_b_is_shown_switches_to_map_a(panel, editor):
    _press(panel, "keep")
    assert panel.shown == []
    _press(panel, "b")
    _press(panel, "a")
    assert panel.shown == [True, False]
    _press(panel, "b")
    assert panel.shows_other
    editor.do("Move", partial(move, numbers=[0], by=(0.05, 0.0)))
    assert panel.shown == [True, False, True, False]
    assert _button(panel, "a").isChecked()
    assert panel.minimumSizeHint().width() <= COLUMN_WIDTH - 8


@pytest.mark.parametrize("write", [save_document, lambda document, path: save_map(document.map, path)])
def test_saved_map_is_applied_in_one_step(panel, editor, tmp_path, write):
    other = mirror(editor.document, [1])
    write(other, tmp_path / "mirrored.npz")
    panel.open_paths([tmp_path / "mirrored.npz"])
    assert isinstance(panel.other, MapDocument)
    assert _button(panel, "b").accessibleName() == "B: mirrored"
    first = editor.document
    _press(panel, "b")
    _press(panel, "take")
    assert editor.history.names == ("Open", "Apply map mirrored")
    assert editor.document.layout == other.layout
    assert editor.document.skin is first.skin
    assert not panel.shows_other
    editor.undo()
    assert editor.document is first


def test_map_of_another_skin_is_rejected_and_map_b_kept(panel, editor, tmp_path):
    _press(panel, "keep")
    kept = panel.other
    save_map(leaf_map(), tmp_path / "leaves.npz")
    panel.open_paths([tmp_path / "leaves.npz"])
    assert "The map is of another skin" in _note(panel).replace(str(tmp_path), "").replace("/leaves.npz: the", "The")
    assert "440 taxels" in _note(panel)
    assert panel.other is kept


@pytest.mark.parametrize("name", ["missing.npz", "text.csv"])
def test_unreadable_file_is_rejected(panel, tmp_path, name):
    (tmp_path / "text.csv").write_text("neither taxels nor a map")
    panel.open_paths([tmp_path / name])
    assert _note(panel).startswith("▲")
    assert name in _note(panel)
    assert panel.other is None


@pytest.mark.long
def test_drawing_is_measured_but_not_displayed(panel, drawing):
    path, points = drawing
    panel.open_paths([path])
    assert isinstance(panel.other, TaxelLayout)
    np.testing.assert_allclose(panel.other.points[np.argsort(panel.other.numbers)], points, atol=1e-6)
    assert not _button(panel, "b").isEnabled()
    assert "taxel positions" in _button(panel, "b").toolTip()
    ((first, second),) = panel.asked
    panel.show_comparison(compare_maps(first, second))
    assert "not displayed" in _note(panel)


def test_drawing_is_applied_by_arranging_and_pinning(panel, editor, drawing):
    path, points = drawing
    before = procrustes(points, editor.document.map.taxel_points, editor.document.skin.first)
    panel.open_paths([path])
    _press(panel, "take")
    assert editor.history.names == ("Open", "Arrange as in the drawing", "Pin as in the drawing")
    assert all(len(pin_places(editor.document, k)) for k in range(3))
    after = procrustes(points, editor.document.map.taxel_points, editor.document.skin.first)
    assert after < 0.5 * before


def test_another_robot_clears_the_comparison(panel, editor):
    ended = []
    panel.ended.connect(lambda: ended.append(1))
    _press(panel, "keep")
    _press(panel, "b")
    editor.open(MapDocument.of(leaf_map()))
    assert panel.other is None
    assert panel.shown == [True, False]
    assert ended == [1]


def test_comparison_is_disabled_in_a_replay(panel, editor):
    _press(panel, "keep")
    editor.set_enabled(enabled=False)
    assert "replay" in _note(panel)
    assert not any(_button(panel, name).isEnabled() for name in ("with", "keep", "a", "b", "take", "forget"))


@pytest.mark.long
def test_numbers_are_shown_in_the_quality_panel(qtbot, editor):
    column = PanelColumn(editor)
    qtbot.addWidget(column)
    column.reveal(column["compare"])
    column.show()
    qtbot.waitExposed(column)
    column["compare"].compare_requested.connect(lambda a, b: column["compare"].show_comparison(compare_maps(a, b)))
    _press(column["compare"], "keep")
    second = column["quality"].findChild(QLabel, "quality-angle-b")
    assert second.isVisible()
    editor.ask(partial(set_method, numbers=[2], method="tutte"))
    first = column["quality"].findChild(QLabel, "quality-angle")
    assert first.text() != second.text()
    assert second.font().bold()
    assert _note(column["compare"]) == ""
    _press(column["compare"], "forget")
    assert not second.isVisible()
    assert first.text().startswith("×")


def test_failure_of_the_worker_is_reported(panel):
    _press(panel, "keep")
    panel.show_failed("the layout does not name each taxel once.")
    assert _note(panel) == "▲ The layout does not name each taxel once."


@pytest.mark.long
def test_key_toggles_between_the_layouts(window):
    window.action("compare").trigger()
    assert not window.column["compare"].shows_other, "no second map yet"
    window.column["compare"].keep_present()
    kept = window.column["compare"].other
    window.editor.do("Move", lambda document: move(document, [0], (0.1, 0.0)))
    window.action("compare").trigger()
    assert window.map_view.picture.document.layout == kept.layout
    window.action("compare").trigger()
    assert window.map_view.picture.document is window.editor.document
