"""Typed numbers: display of values beyond the limits, and the time of the signal."""

from __future__ import annotations

import math

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_widgets.common.number_field import NumberField, decimals_of


@pytest.mark.parametrize(("step", "digits"), [(1.0, 0), (0.5, 1), (0.05, 2), (10.0, 0)])
def test_step_sets_the_number_of_decimals(step, digits):
    assert decimals_of(step) == digits


def test_number_outside_the_limits_is_shown_but_cannot_be_typed(qtbot):
    field = NumberField("Force", "N", 1.0, 5.0, 0.5, "How hard")
    qtbot.addWidget(field)
    values = []
    field.valueChanged.connect(values.append)
    for number, text in ((3.0, "3.0\u202fN"), (25.0, "25.0\u202fN"), (math.inf, "∞"), (0.0, "0.0\u202fN")):
        field.show_number(number)
        assert field.text() == text
    assert values == []
    field.show_number(3.0)
    field.selectAll()
    QTest.keyClicks(field, "4.5")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert values == [4.5]
    field.show_words("—")
    assert field.text() == "—"


def test_special_values_in_words_have_no_unit(qtbot):
    field = NumberField("Force", "N", 1.0, 5.0, 0.5, "How hard")
    qtbot.addWidget(field)
    field.show_number(math.inf)
    field.show()
    qtbot.waitExposed(field)
    QApplication.processEvents()  # Qt writes the text again
    assert field.text() == "∞"
    QTest.keyClick(field, Qt.Key.Key_Down)
    assert field.text() == "4.5\u202fN"
