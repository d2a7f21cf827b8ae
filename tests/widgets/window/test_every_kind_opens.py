"""Files of every kind are opened the same way by a dialog, a drop and the command line."""

from __future__ import annotations

from fnmatch import fnmatch

import pytest

from tactile_maps.core.file_kinds import FileKind
from tactile_widgets.__main__ import main
from tactile_widgets.common.file_dialogs import (
    OPENED,
    RECORDING_FILTER,
    ROBOT_FILTER,
    SCENE_FILTER,
    STUDY_FILTER,
    taxel_filter,
)
from tactile_widgets.window import application, display
from tests.support.file_kinds import KINDS, write_every_kind
from tests.widgets.presenters.files.test_file_presenter import drop

OPENED_NAMES = [name for name, kind in KINDS.items() if kind in OPENED]


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return write_every_kind(tmp_path_factory.mktemp("kinds"))


@pytest.fixture
def opened(window_again, monkeypatch):
    """Scenes and paths that the window opens."""
    found = []
    presenters = window_again.presenters.files
    monkeypatch.setattr(window_again.live, "open_scene", lambda scene, file=None: found.append(scene))
    monkeypatch.setattr(window_again.live, "open_recording", found.append)
    monkeypatch.setattr(presenters._map_files, "open", found.append)
    monkeypatch.setattr(presenters._studies, "open", found.append)
    return found


@pytest.mark.long
def test_dialog_drop_and_command_line_agree(window_again, opened, files, monkeypatch):
    monkeypatch.setattr(type(window_again.live), "prepared", None)  # taxels are then put on their usual carrier
    monkeypatch.setattr(display, "require_display", lambda: None)
    launched = []
    monkeypatch.setattr(application, "launch", lambda scene, then=None, file=None: launched.append((scene, then)) or 0)
    for name in OPENED_NAMES:
        path = str(files[name])
        window_again.presenters.files.open_path(path)
        drop(window_again, path)
        by_dialog, by_drop = opened
        assert main(["gui", path]) == 0
        scene, then = launched.pop()
        assert by_dialog == by_drop, name
        assert by_dialog == (scene if then is None else then), name
        opened.clear()


def test_kinds_that_cannot_be_opened_alone_are_rejected_alike(window_again, opened, files, capsys, monkeypatch):
    monkeypatch.setattr(display, "require_display", lambda: None)
    for name in set(KINDS) - set(OPENED_NAMES):
        window_again.presenters.files.open_path(str(files[name]))
        assert "cannot be opened here" in window_again.notification_bar.text
        assert main(["gui", str(files[name])]) == 2
        assert "cannot be opened here" in capsys.readouterr().err
    assert not opened


def test_dialogs_list_files_of_every_kind():
    filters = {
        FileKind.RECORDING: RECORDING_FILTER,
        FileKind.SCENE: SCENE_FILTER,
        FileKind.STUDY_TABLE: STUDY_FILTER,
        FileKind.TAXELS: taxel_filter(),
        FileKind.SKIN: taxel_filter(),
        FileKind.LAYOUT: taxel_filter(),
    }
    listed = [name for name in OPENED_NAMES if KINDS[name] is not FileKind.MAP and "." in name]
    for name in listed:
        patterns = filters.get(KINDS[name], ROBOT_FILTER).partition("(")[2].rstrip(")").split()
        assert any(fnmatch(name.lower(), pattern) for pattern in patterns), name
