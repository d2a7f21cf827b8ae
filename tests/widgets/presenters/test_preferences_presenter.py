"""Preferences: each acts at once, is stored, and is restored to its default."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QMessageBox

from tactile_widgets.common.file_dialogs import FileDialog
from tactile_widgets.common.settings import NavigationStyle, Preferences, Question
from tactile_widgets.panels.control.posture_panel import PosturePanel
from tactile_widgets.presenters.files.recordings_presenter import TrashedFile
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import run

MIDDLE = Qt.MouseButton.MiddleButton


@pytest.fixture
def window(window_again):
    yield window_again
    window_again.presenters.preferences.use(Preferences())
    window_again.presenters.preferences.dialog.close()


@pytest.fixture
def dialog(window):
    window.action("preferences").trigger()
    return window.presenters.preferences.dialog


def choose(box, value):
    """Choose an entry as a user does."""
    box.setCurrentIndex(box.findData(value))
    box.activated.emit(box.currentIndex())


def drag(view, button):
    """Drag the middle of a view's canvas to the right and down."""
    canvas = view.display.canvas.widget
    start = QPointF(canvas.rect().center())
    for kind, at, held in (
        (QEvent.Type.MouseButtonPress, start, button),
        (QEvent.Type.MouseMove, start + QPointF(30, 20), button),
        (QEvent.Type.MouseButtonRelease, start + QPointF(30, 20), Qt.MouseButton.NoButton),
    ):
        place = canvas.mapToGlobal(at)
        cause = Qt.MouseButton.NoButton if kind is QEvent.Type.MouseMove else button
        QApplication.sendEvent(canvas, QMouseEvent(kind, at, place, cause, held, Qt.KeyboardModifier.NoModifier))


def test_style_of_navigation_moves_the_camera_at_once(window, dialog):
    view = window.robot_view
    seen = {}
    hints = []
    for style in NavigationStyle:
        choose(dialog.navigation, style)
        before = view.display.actors.viewpoint
        drag(view, MIDDLE)
        hints.append(window.hint_bar.findChild(QLabel, "hint-1").text())
        after = view.display.actors.viewpoint
        distance = np.linalg.norm(after.eye - after.focus) / np.linalg.norm(before.eye - before.focus)
        moved = not np.allclose(after.focus, before.focus)
        seen[style] = "pan" if moved else "turn" if distance == pytest.approx(1.0) else "zoom"
    assert seen == {
        NavigationStyle.STANDARD: "pan",
        NavigationStyle.MUJOCO: "zoom",
        NavigationStyle.BLENDER: "turn",
    }
    assert [hint.partition(":")[0] for hint in hints] == ["1  Right-drag", "1  Ctrl-drag", "1  Middle-drag"]


def test_folder_of_recordings_can_be_typed(window, dialog, tmp_path, monkeypatch):
    monkeypatch.setattr(FileDialog, "choose_folder", lambda *_args: pytest.fail("Return chose a folder"))
    before = dialog.folder.text()

    def enter(text):
        dialog.folder.selectAll()
        QTest.keyClicks(dialog.folder, text)
        QTest.keyClick(dialog.folder, Qt.Key.Key_Return)

    (tmp_path / "file").touch()
    for text in ("nonsense *?", str(tmp_path / "file" / "below")):
        enter(text)
        assert dialog.isVisible()
        assert text in dialog.problem.text()
        assert dialog.problem.isVisible()
        assert dialog.problem.height() >= dialog.problem.heightForWidth(dialog.problem.width()), "not cut"
        below = dialog.folder.geometry().bottom()
        assert below < dialog.problem.y() < dialog.theme.y()
        assert window.notification_bar.text == "", "the dialog covers the messages of the window"
        assert dialog.folder.text() == before
        assert window.settings.preferences.recordings == ""
    enter(str(tmp_path / "new" / "folder"))
    assert not dialog.problem.isVisible()
    assert dialog.folder.text() == window.settings.preferences.recordings == str(tmp_path / "new" / "folder")
    assert dialog.folder.text() in dialog.folder.toolTip(), "a long path is cut"
    assert (tmp_path / "new" / "folder").is_dir()
    dialog.folder.selectAll()
    QTest.keyClick(dialog.folder, Qt.Key.Key_Delete)
    QTest.keyClick(dialog.folder, Qt.Key.Key_Return)
    assert window.settings.preferences.recordings == ""
    assert dialog.folder.text() == before


def test_folder_in_which_no_file_can_be_created_is_rejected(window, dialog, choose_file):
    """The message of the dialog and of a recording names the remedy."""
    before = dialog.folder.text()
    choose_file("choose_folder", "/proc")
    left_click(dialog.choose)
    remedy = "Choose another folder of recordings in Edit > Preferences."
    expected = f"/proc: no recording can be written to this folder. {remedy}"
    assert (
        dialog.problem.text()
        == "▲ /proc: no recording can be written to this folder. Choose another folder of recordings."
    )
    assert dialog.folder.text() == before
    window.presenters.preferences.use(Preferences(recordings="/proc"))  # of a version that did not check it
    window.action("record").trigger()
    assert window.notification_bar.text == expected
    assert window.live.recording.recorder is None


def test_preferences_act_are_stored_and_restored(window, dialog, tmp_path, monkeypatch, choose_file):
    chosen = tmp_path / "elsewhere"
    chosen.mkdir()
    choose_file("choose_folder", chosen)
    dialog.choose.click()
    assert dialog.folder.text() == str(chosen)
    window.action("record").trigger()
    run(window, 0.1)
    window.action("record").trigger()
    (file,) = chosen.glob("*.mcap")
    choose(dialog.theme, "light")
    assert window.theme.name == "light"
    choose(dialog.rate, 10)
    assert window.robot_view.display._drawing.shortest_ms == 100
    posture = window.column.get(PosturePanel)
    window.column.reveal(posture)
    assert "°" in posture.sliders[0]._value.suffix()
    choose(dialog.angles, True)
    assert "rad" in posture.sliders[0]._value.suffix()
    home = float(window.live.prepared.robot.home[0])
    assert posture.sliders[0]._value.value() == pytest.approx(home, abs=0.006)
    deleted = []
    trash = "tactile_widgets.presenters.files.recordings_presenter._to_trash"
    monkeypatch.setattr(trash, lambda path: deleted.append(path) or TrashedFile(path, None))
    question = dialog.questions[Question.TRASH]
    left_click(question, QPoint(8, question.height() // 2))
    window.presenters.recordings.delete(file)
    assert deleted == [file]
    assert window.settings.preferences == Preferences(
        str(chosen), "light", NavigationStyle.STANDARD, 10, True, frozenset({Question.TRASH})
    )
    dialog.restore.click()
    assert window.settings.preferences == Preferences()
    assert window.theme.name == "dark"
    assert "°" in posture.sliders[0]._value.suffix()
    window.presenters.recordings.delete(file)
    box = window.findChild(QMessageBox, "delete-recording")
    box.reject()
    assert deleted == [file]
