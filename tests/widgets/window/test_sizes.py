"""Sizes of the window: the first one fits the screen, and bars lose nothing that a person needs in a narrow window."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QMargins, QRect, QSize, Qt
from PySide6.QtWidgets import QApplication, QLabel, QToolButton

from tactile_widgets.common.make import ElidedLabel
from tactile_widgets.window.main_window import PREFERRED_SIZE, first_rectangle

WORDS = "Follow a path drawn on the map"


@pytest.fixture
def window(window_again):
    """The module's window; no job runs afterwards."""
    yield window_again
    window_again.loading_bar.clear()


@pytest.mark.parametrize(
    "room",
    [QRect(0, 0, 1366, 728), QRect(0, 27, 910, 485), QRect(1920, 0, 1280, 800), QRect(0, 0, 1400, 900)],
    ids=["laptop", "laptop at scale 1.5", "second screen", "preferred size, except for the frame"],
)
def test_first_size_fits_with_the_frame(room):
    place = first_rectangle(room)
    assert room.contains(place.marginsAdded(QMargins(8, 40, 8, 8)))
    assert place.width() >= room.width() - 16 or place.width() == PREFERRED_SIZE.width()


def test_preferred_size_is_centred_on_a_large_screen():
    place = first_rectangle(QRect(0, 0, 2560, 1440))
    assert place.size() == PREFERRED_SIZE
    assert (place.center() - QRect(0, 0, 2560, 1440).center()).manhattanLength() <= 2


@pytest.mark.long
def test_small_window_shows_everything(window):
    window.resize(QSize(900, 600))
    QApplication.processEvents()  # the plots give room
    assert window.size() == QSize(900, 600)
    assert window.minimumSizeHint().height() <= 480, "a laptop of 768 px at scale 1.5"


@pytest.mark.parametrize(("width", "worded", "named"), [(900, False, False), (1280, True, False), (1366, True, True)])
def test_toolbar_shows_texts_if_they_fit(window, width, worded, named):
    window.resize(width, 700)
    QApplication.processEvents()
    bar = window.session_bar
    assert bar.has_text == worded
    assert bar.findChild(QLabel, "toolbar-map").isVisible() == named
    text_and_icon = Qt.ToolButtonStyle.ToolButtonTextBesideIcon
    assert (bar.select.toolButtonStyle() is text_and_icon) == worded
    for name in ("pause", "step", "reset", "record", "poke", "undo", "redo"):
        button = bar.widgetForAction(window.action(name))
        assert button.isVisible(), name
        assert button.geometry().right() <= width
        assert button.accessibleName()


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


def test_hints_of_tools_fit_next_to_a_readout(window, prepared):
    window.resize(1366, 768)
    window.hint_bar.hide()
    window.map_view.readout_changed.emit(window.map_view.words_for(prepared.skin.taxel_point(70)))
    hints = []
    for spec in window.presenters.tools.specs:
        window.presenters.view.set_tool(spec.kind)
        for _ in range(3):
            QApplication.processEvents()
        hints.append(window.status_line.currentMessage())
        assert window.status_line.shown == hints[-1], spec.text
    assert len([*filter(None, hints)]) >= 7
