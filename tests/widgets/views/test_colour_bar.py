"""The pressure scale: it reads right, and the hand can change where it ends."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDoubleSpinBox

from tactile_widgets.common.colours import DARK, LIGHT, PressureScale
from tactile_widgets.views.colour_bar import BAR_LEFT, BAR_WIDTH, MAXIMA, ColourBar, ticks
from tests.widgets.support.mouse import left_double_click


@pytest.fixture
def bar(qtbot):
    bar = ColourBar(DARK, PressureScale(20.0))
    qtbot.addWidget(bar)
    bar.resize(bar.sizeHint())
    bar.show()
    qtbot.waitExposed(bar)
    return bar


@pytest.fixture
def chosen(bar):
    chosen = []
    bar.maximum_changed.connect(chosen.append)
    return chosen


def test_colours_run_from_zero_at_the_bottom_to_the_end_at_the_top(bar):
    image = bar.grab().toImage()
    scale = PressureScale(20.0)
    x = round(BAR_LEFT + BAR_WIDTH / 2)
    for kilopascals, entry in ((0.1, 0), (19.9, -1)):
        drawn = image.pixelColor(x, round(bar.y_of(kilopascals)))
        expected = int(scale.lut[entry])
        channels = [(expected >> shift) & 255 for shift in (16, 8, 0)]
        assert [drawn.red(), drawn.green(), drawn.blue()] == pytest.approx(channels, abs=8)


def test_double_click_opens_a_field_for_the_end(bar, chosen):
    left_double_click(bar, QPoint(30, 200))
    editor = bar.findChild(QDoubleSpinBox)
    assert editor.isVisible()
    QTest.keyClicks(editor, editor.locale().toString(35.0, "f", 1))
    QTest.keyClick(editor, Qt.Key.Key_Return)
    assert chosen == [35.0]
    assert not editor.isVisible()


def test_unchanged_end_emits_no_signal(bar, chosen):
    editor = bar.findChild(QDoubleSpinBox)
    for leave in (Qt.Key.Key_Return, Qt.Key.Key_Escape):
        QTest.keyClick(bar, Qt.Key.Key_Space)
        assert editor.isVisible()
        QTest.keyClick(editor, leave)
        assert not editor.isVisible()
    assert chosen == []


def test_escape_discards_typed_text(bar, chosen):
    bar.edit()
    editor = bar.findChild(QDoubleSpinBox)
    QTest.keyClicks(editor, "7")
    QTest.keyClick(editor, Qt.Key.Key_Escape)
    assert chosen == []
    assert not editor.isVisible()


@pytest.mark.parametrize(("key", "end"), [(Qt.Key.Key_Up, 50.0), (Qt.Key.Key_Down, 10.0)])
def test_keys_select_the_next_round_end(bar, chosen, key, end):
    QTest.keyClick(bar, key)
    assert chosen == [end]


def test_keys_stop_at_the_last_end(bar, chosen):
    bar.set_scale(PressureScale(MAXIMA[-1]))
    QTest.keyClick(bar, Qt.Key.Key_Up)
    assert chosen == []


def test_menu_offers_round_ends(bar, chosen):
    menu = bar.build_menu()
    checked = [action.data() for action in menu.actions() if action.isChecked()]
    assert checked == [20.0]
    next(action for action in menu.actions() if action.data() == 100.0).trigger()
    assert chosen == [100.0]
    menu.deleteLater()


def test_peak_is_marked_and_indicated_beyond_the_end(bar):
    quiet = bar.grab().toImage()
    bar.set_peak(10.0)
    within = bar.grab().toImage()
    bar.set_peak(60.0)
    beyond = bar.grab().toImage()
    assert quiet != within
    assert beyond != within
    bar.set_peak(0.0)
    assert bar.grab().toImage() == quiet


def test_colour_bar_has_an_accessible_description(bar):
    assert bar.accessibleName() == "Pressure scale"
    bar.set_scale(PressureScale(50.0))
    assert "50" in bar.accessibleDescription()


def test_theme_changes_the_background_of_the_colour_bar(bar):
    dark = bar.grab().toImage().pixelColor(1, 1)
    bar.set_theme(LIGHT)
    assert bar.grab().toImage().pixelColor(1, 1) != dark


@pytest.mark.parametrize("maximum", [0.1, 2.0, 20.0, 35.0, 500.0, 9999.0])
@pytest.mark.parametrize("most", [2, 5, 12])
def test_ticks_are_round_few_and_start_at_zero(maximum, most):
    values = ticks(maximum, most=most)
    assert values[0] == 0.0
    assert 2 <= len(values) <= most + 1
    assert values[-1] <= maximum * (1 + 1e-9)
