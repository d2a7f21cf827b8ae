"""The lower edge loses nothing a person needs, however narrow the window; words that have no room are cut."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import QApplication, QToolButton

from tactile_widgets.common.make import ElidedLabel

WORDS = "Follow a path drawn on the map"


@pytest.fixture
def window(window_again):
    """The module's window, of the usual size again."""
    yield window_again
    window_again.loading_bar.clear()
    window_again.resize(1400, 900)


@pytest.fixture
def label(qtbot):
    made = ElidedLabel("scene-title")
    qtbot.addWidget(made)
    made.setText(WORDS)
    made.show()
    return made


def test_label_shows_the_whole_text_if_it_fits(label):
    label.resize(label.sizeHint())
    assert label.shown == WORDS
    assert label.toolTip() == ""


def test_label_elides_its_text_and_the_tool_tip_shows_it(label):
    label.resize(80, 20)
    assert label.shown.endswith("…")
    assert WORDS.startswith(label.shown[:-1])
    assert label.toolTip() == WORDS
    label.setText("Short")
    assert label.toolTip() == ""
    assert label.minimumSizeHint().width() < 40


@pytest.mark.long
@pytest.mark.parametrize("size", [(900, 600), (1107, 700), (1366, 768)])
def test_status_line_is_complete_at_every_size(window, qtbot, size):
    line = window.status_line
    line.show_title("Arm")
    line.readout.setText("forearm, taxel 17 (id 86999, module 7, channel 4), 12.3 kPa, x 230.5 mm, y 112.0 mm")
    text = "Flattening the forearm, 3 of 12"
    line.loading.show_progress(text, 0.4)
    window.resize(*size)
    qtbot.waitUntil(lambda: window.size().toTuple() == size)
    QApplication.processEvents()
    cancel = line.loading.findChild(QToolButton, "loading-cancel")
    for part in (line.factor, line.loading, cancel):
        corner = part.mapTo(window, part.rect().bottomRight())
        assert part.isVisible()
        assert corner.x() < size[0]
        assert corner.y() < size[1]
        assert part.width() >= part.minimumSizeHint().width()
    shown = line.loading.text_label
    assert shown.fontMetrics().horizontalAdvance(text) <= shown.width(), "the text of loading is whole"
    path = f"Loading {'/folder' * 40}/robot.urdf"
    line.loading.show_progress(path, None)
    QApplication.processEvents()
    assert shown.shown.startswith("Loading /")
    assert shown.shown.endswith("robot.urdf")
    assert shown.toolTip() == path


def test_cancel_does_not_move_when_the_readout_changes(window):
    line = window.status_line
    line.loading.show_progress("Placing taxels", 0.4)
    QApplication.processEvents()
    cancel = line.loading.findChild(QToolButton, "loading-cancel")
    before = cancel.mapTo(window, cancel.rect().topLeft())
    line.readout.setText("forearm, taxel 17, 12.3 kPa, x 230.5 mm, y 112.0 mm")
    QApplication.processEvents()
    assert cancel.mapTo(window, cancel.rect().topLeft()) == before
