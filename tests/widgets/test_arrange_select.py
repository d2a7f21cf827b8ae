"""Selecting patches with a real mouse, on the map and on the body, and hiding those that are."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtTest import QTest

from tests.widgets.arranging import CONTROL, LEFT, NONE, SHIFT, Bench
from tests.widgets.hand_made import leaf_map
from widgets.body_marks import NO_MARKS
from widgets.edit_tool import Place

BESIDE = (6.0, 300.0)
FREE = np.array([23.0, -31.0])
"""A drag that lines up with nothing."""


@pytest.fixture
def bench(qtbot):
    return Bench(qtbot, leaf_map())


def test_clicks_select(bench):
    left, right = bench.over(0), bench.over(1)
    for pixel, keys, selected in (
        (left, NONE, (0,)),
        (right, NONE, (1,)),
        (left, CONTROL, (0, 1)),
        (right, SHIFT, (0,)),
        (BESIDE, SHIFT, (0,)),
        (BESIDE, NONE, ()),
    ):
        bench.click(pixel, keys)
        assert bench.editor.selected == selected
    assert bench.steps == ()


@pytest.mark.parametrize("by", [(40.0, 25.0), (0.0, 40.0)])
def test_a_press_that_moved_is_never_a_click(bench, by):
    bench.editor.select([0, 1])
    start = bench.over(0)
    bench.drag(start, by)
    bench.move(start)
    bench.release(start)
    assert bench.editor.selected == (0, 1)
    assert bench.placement(0).offset == pytest.approx(leaf_map().layout.placements[0].offset)


def test_a_hand_that_trembles_clicks(bench):
    bench.editor.select([0, 1])
    start = bench.over(0)
    bench.press(start)
    bench.move(start + 2)
    bench.release(start + 2)
    assert bench.editor.selected == (0,)
    assert bench.steps == ()


def test_a_release_elsewhere_is_no_click_even_without_a_move_between(bench):
    bench.editor.select([0, 1])
    bench.press(bench.over(0))
    bench.release(bench.over(0) + FREE)
    assert bench.editor.selected == (0, 1)
    assert bench.steps == ()


def test_escape_then_selects_none(bench):
    bench.click(bench.over(0))
    cleared = []
    bench.view.cleared.connect(lambda: cleared.append(True))
    QTest.keyClick(bench.view, Qt.Key.Key_Escape)
    assert bench.editor.selected == ()
    assert not cleared
    QTest.keyClick(bench.view, Qt.Key.Key_Escape)
    assert cleared


def test_a_box_selects_what_it_meets(bench):
    low, high = bench.pixels(bench.document.map.boxes[1])
    start, end = np.array([high[0] + 8, high[1] - 8]), (low + high) / 2
    before = bench.picture()
    bench.drag(start, end - start)
    assert bench.editor.selected == (1,)
    assert bench.picture() != before
    bench.release(end)
    assert bench.editor.selected == (1,)
    bench.drag(start, np.array([4.0, high[1] - 8]) - start)
    QTest.keyClick(bench.view, Qt.Key.Key_Escape)
    assert bench.editor.selected == (1,)
    assert bench.steps == ()


def test_h_hides_and_alt_h_shows_all(bench):
    bench.editor.select([1])
    QTest.keyClick(bench.view, Qt.Key.Key_H)
    assert [patch.visible for patch in bench.document.patches] == [True, False]
    bench.click(bench.over(1))
    assert bench.editor.selected == ()
    QTest.keyClick(bench.view, Qt.Key.Key_H, Qt.KeyboardModifier.AltModifier)
    assert all(patch.visible for patch in bench.document.patches)
    assert bench.steps == ("Hide patches", "Show all patches")


def test_on_the_body_a_click_selects_and_a_drag_does_nothing(bench):
    at = bench.document.skin.taxel_point(0)
    place = Place(at, None, 1e-3)
    assert bench.tool.body_marks() == NO_MARKS
    for press in ((0, 0), (60, 0)):
        event = _event(press)
        assert bench.tool.press(place, _event((0, 0)))
        bench.tool.move(place, event)
        bench.tool.release(place, event)
    assert bench.editor.selected == (0,)
    assert bench.steps == ()
    marks = bench.tool.body_marks()
    assert len(marks.lines) == 1
    assert bench.tool.body_marks() is marks


def _event(pixel):
    return QMouseEvent(QEvent.Type.MouseMove, QPointF(*pixel), QPointF(*pixel), LEFT, LEFT, NONE)
