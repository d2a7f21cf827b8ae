"""Every dialog for a file opens in the folder of the last file of its kind that could be used."""

from __future__ import annotations

import ast
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication, QDialog, QPushButton

from tactile_maps.core.assets import asset
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.document_file import save_document
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.session import Session
from tactile_maps.skin.formats.taxel_files import write_taxels
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.common.file_dialogs import FileDialog
from tactile_widgets.panels.maps.compare_panel import ComparePanel
from tests.widgets.support.window_driver import run

ROOT = Path(__file__).resolve().parents[3]
READINGS = "# unit: Pa\ntime,0,1\n0.0,0,0\n0.1,0,0\n"


@pytest.fixture(scope="module")
def good(prepared, tmp_path_factory):
    """Folder with a usable file for each dialog, by name."""
    folder = tmp_path_factory.mktemp("good")
    session = Session(prepared)
    with Recorder(prepared, folder / "own.mcap", viewers=False) as recorder:
        session.submit(PokePressed(1, prepared.skin.taxel_point(30)))
        for _ in range(40):
            recorder.write(session.tick(), session.inputs)
    shutil.copytree(asset("robots", "arm"), folder, dirs_exist_ok=True)
    shutil.copy(min(asset("findings").glob("*.csv")), folder / "study.csv")
    (folder / "scene.toml").write_text("robot = 'arm'\n[cover]\nlinks = ['hand']\ntaxels = 60\n")
    (folder / "script.toml").write_text(
        f"[[stimuli]]\nkind = 'poke'\npatch = '{prepared.skin.patches[0].name}'\nforce = 1.0\n"
    )
    save_document(MapDocument.of(prepared.map), folder / "map.npz")
    write_taxels(prepared.skin, folder / "taxels.csv")
    (folder / "readings.csv").write_text(READINGS)
    return folder


class Chooser:
    """Answers of the user in the file dialogs, and where each dialog opened."""

    def __init__(self, patching: pytest.MonkeyPatch) -> None:
        self.opened: list[Path] = []
        self.answer = ""
        for name in ("open_file", "save_file", "choose_folder"):
            patching.setattr(FileDialog, name, self._choose)
        patching.setattr(FileDialog, "open_files", lambda *asked: [path for path in [self._choose(*asked)] if path])

    def _choose(self, _parent, _title, start, _kinds=""):
        self.opened.append(Path(start))
        return self.answer


@pytest.fixture
def chooser(monkeypatch):
    return Chooser(monkeypatch)


def action(name, window):
    window.action(name).trigger()


def compare(window):
    window.column.get(ComparePanel).findChild(QPushButton, "compare-with").click()


def stimulus(window):
    window.action("compare_controllers").trigger()
    box = window.presenters.comparison.board.stimulus._box
    row = box.findData("file")
    box.setCurrentIndex(row)
    box.activated.emit(row)


def address(window):
    """Choose a file of readings, and connect to it."""
    window.action("connect").trigger()
    dialog = window.presenters.live_input.dialog
    dialog.kind.setCurrentText("File")
    (button,) = [one for one in dialog.findChildren(QPushButton) if one.accessibleName() == "Choose the file…"]
    button.click()
    dialog.go.click()
    dialog.reject()


def close_dialogs():
    for top in QApplication.topLevelWidgets():
        if isinstance(top, QDialog):
            top.close()


OPENED: dict[str, tuple[Callable, str]] = {
    "robot": (partial(action, "open_robot"), "arm.xml"),
    "scene": (partial(action, "open_scene"), "scene.toml"),
    "recording": (partial(action, "open_recording"), "own.mcap"),
    "map": (partial(action, "open_map"), "map.npz"),
    "study": (partial(action, "open_study"), "study.csv"),
    "script": (partial(action, "play_script"), "script.toml"),
    "film": (partial(action, "film_file"), "own.mcap"),
    "export": (partial(action, "export_recording"), "own.mcap"),
    "overlay": (partial(action, "overlay_recording"), "own.mcap"),
    "compare": (compare, "map.npz"),
    "stimulus": (stimulus, "own.mcap"),
    "connect": (address, "readings.csv"),
    "taxels": (partial(action, "import_taxels"), "taxels.csv"),
}
"""How the user opens each dialog for a file to read, and a usable file, by name of the case."""


@pytest.mark.long
def test_folder_of_a_file_is_remembered_once_it_was_used(new_window, scene_cache, chooser, good, tmp_path, prepared):
    window = new_window
    window.context.dialogs.document = lambda: None  # its folder would be proposed first
    for case, (ask, name) in OPENED.items():
        window.settings._store.clear()
        bad = tmp_path / name
        bad.write_bytes(b"\0nothing that can be read")
        if case == "overlay":
            window.live.open_recording(good / name)
        found = []
        for path in (bad, good / name, ""):
            chooser.answer = str(path)
            ask(window)
            run(window, 0.01)
            close_dialogs()
            found.append(chooser.opened[-1])
        assert found == [tmp_path, tmp_path, good], case
        window.live.connection.close()
        window.live.replay.leave()
        window.live.show_prepared(prepared)


def test_files_of_a_connection_share_no_folder(new_window, chooser, good, tmp_path):
    """The dialogs for mapping, IDs and calibration remember their own folders, once the connection succeeded."""
    new_window.settings.source = "File", str(good / "readings.csv")
    new_window.action("connect").trigger()
    dialog = new_window.presenters.live_input.dialog
    assert (dialog.kind.currentText(), dialog.address.text()) == new_window.settings.source
    chosen = {"IDs": tmp_path / "ids" / "ids.csv", "calibration": tmp_path / "gains" / "gains.toml"}
    for path in chosen.values():
        path.parent.mkdir()
    chosen["IDs"].write_text("id,taxel\n0,0\n1,1\n")
    chosen["calibration"].write_text("gain = 'broken'\n")
    buttons = {
        word: button
        for word in chosen
        for button in dialog.findChildren(QPushButton)
        if word in button.accessibleName()
    }

    def choose(word, path):
        chooser.answer = str(path)
        buttons[word].click()
        return chooser.opened[-1]

    for word, path in chosen.items():
        assert choose(word, path) == tmp_path
    dialog.go.click()
    assert dialog.isVisible()
    assert choose("calibration", "") == tmp_path
    chosen["calibration"].write_text("gain = 2.0\n")
    dialog.go.click()
    assert not dialog.isVisible(), dialog.problem.text()
    for word, path in chosen.items():
        assert choose(word, "") == path.parent
    new_window.live.connection.close()


def test_only_the_dialogs_of_the_window_ask_for_files():
    """A file dialog that is opened elsewhere remembers no folder."""
    users = []
    for path in (ROOT / "widgets").rglob("*.py"):
        if "FileDialog" not in (text := path.read_text("utf8")):
            continue
        names = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
        if names & {"FileDialog", "QFileDialog"}:
            users.append(path.name)
    assert sorted(users) == ["dialogs.py", "file_dialogs.py"]
