"""Films from the menu: of the view or of the session, made in the background, complete or not at all."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication

from tactile_widgets.common.file_dialogs import FileDialog
from tactile_widgets.dialogs.figures.film_job import FilmRequest
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import cancel, run

pytestmark = pytest.mark.qt_log_ignore("This plugin does not support")


@pytest.fixture
def window(window_again):
    """Window that makes no film."""
    yield window_again
    window_again.presenters.film.close()
    window_again.notification_bar.clear()


def begin(window, folder, monkeypatch):
    """Film a short session by the menu; the film's file."""
    target = folder / "arm.mp4"
    monkeypatch.setattr(FileDialog, "save_file", lambda *_args: str(target))
    film = window.presenters.film
    window.action("film").trigger()
    assert window.live.recording.recorder is not None, "live, a recording is begun"
    assert window.action("film").text().replace("&", "") == "Stop and film…"
    run(window, 0.2)
    window.action("film").trigger()
    window.live.pump()
    QApplication.processEvents()
    dialog = film.dialog
    assert "pictures" in dialog.note.text()
    sizes = [dialog.size_px.itemData(row) for row in range(dialog.size_px.count())]
    assert sizes
    assert not np.any(np.array(sizes) % 2), "as H.264 requires"
    dialog.rate.setValue(10)
    dialog.part.last.setValue(0.1)
    assert dialog.note.text().startswith("2 pictures")
    dialog.part.first.setValue(0.1)
    assert not dialog.film.isEnabled()
    dialog.part.first.setValue(0.0)
    left_click(dialog.film)
    return target


def parts(folder):
    return [path.name for path in folder.iterdir() if "film" in path.name]


def test_cancelled_film_leaves_no_file(window, tmp_path, monkeypatch):
    target = begin(window, tmp_path, monkeypatch)
    assert parts(tmp_path), "it is made in a folder of its own"
    cancel(window)
    assert window.presenters.film._executor.pid is None
    assert not target.exists()
    assert not parts(tmp_path)


def test_film_in_an_unwritable_folder_shows_a_message(window, tmp_path):
    window.presenters.film.make(FilmRequest(tmp_path / "a.mcap", tmp_path / "nowhere" / "a.mp4"))
    assert "nowhere" in window.notification_bar.text
    assert window.presenters.film._target is None


@pytest.mark.long
def test_session_is_filmed_in_the_background(window, tmp_path, monkeypatch, qtbot):
    av = pytest.importorskip("av", reason="films need PyAV, of the extra 'export'")
    target = begin(window, tmp_path, monkeypatch)
    qtbot.waitUntil(lambda: window.presenters.film._target is None, timeout=120_000)
    assert str(target) in window.notification_bar.text
    with av.open(str(target)) as film:
        assert len(list(film.decode(video=0))) == 2
    assert not parts(tmp_path)
