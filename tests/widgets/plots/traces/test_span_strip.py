"""Strips of limits: whole names where there is room, and clicks on their bars."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPointF

from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_widgets.common.colours import DARK
from tactile_widgets.plots.traces.history import LimitHistory
from tactile_widgets.plots.traces.span_strip import LimitStrip

LONG = Limit(LimitKind.CONTACT_IMMOBILE)
SHORT = Limit(LimitKind.JOINT_SPEED)


@pytest.fixture
def strip(qtbot):
    """Strip with a long and a short name, limited for the last second."""
    memory = LimitHistory()
    for tick in range(6):
        memory.take(0.2 * tick, [LONG, SHORT])
    made = LimitStrip(memory, list, DARK, None)
    qtbot.addWidget(made)
    made.resize(180, 160)
    made.draw()
    made.show()
    return made


def test_long_name_wraps_where_there_is_room_and_is_elided_otherwise(strip):
    names = [lines for _, _, lines in strip._rows._placed()]
    assert [" ".join(lines) for lines in names] == [LONG.kind.title, SHORT.kind.title]
    assert [len(lines) for lines in names] == [2, 1]
    high = strip.grab().toImage()
    strip.resize(180, 90)
    assert [lines for _, _, lines in strip._rows._placed()] == [[LONG.kind.title], [SHORT.kind.title]]
    assert strip.grab().toImage() != high
    assert LONG.kind.title.capitalize() in strip.toolTip()


def test_click_selects_the_bar_below_a_name_of_two_lines(strip):
    heard = []
    strip.clicked.connect(heard.append)
    rows = strip._rows
    for _, top, lines in rows._placed():
        low = top + 17 + 13 * (len(lines) - 1)
        strip.click(QPointF(rows.mapTo(strip, rows.rect().topLeft())) + QPointF(rows._x(-0.5), low))
    assert heard == pytest.approx([-1.0, -1.0])
    strip.click(QPointF(rows.mapTo(strip, rows.rect().topLeft())) + QPointF(rows._x(-6.0), 17))
    assert len(heard) == 2
