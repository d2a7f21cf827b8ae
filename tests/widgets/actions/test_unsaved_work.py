"""No action of the table, and no dropped file, replaces unsaved edits of the map without a question."""

from __future__ import annotations

import pickle
import shutil
from dataclasses import replace

import pytest
from PySide6.QtWidgets import QMessageBox

from tactile_maps.core.assets import asset
from tactile_maps.editing.arrange import rotate
from tactile_maps.editing.document_file import save_document
from tactile_maps.scene.scene_file import load_scene, scene_to_toml
from tactile_maps.skin.formats.taxel_files import write_taxels
from tactile_widgets.common.file_dialogs import FileDialog
from tactile_widgets.dialogs.dialogs import Button
from tests.widgets.actions.test_every_action import EFFECTS, TICK, Bench
from tests.widgets.support.window_driver import answer, drop, kept_documents, press_map, run

pytestmark = pytest.mark.long


class CarefulBench(Bench):
    """A bench whose file dialogs choose files that can be opened, and whose scenes have skins of their own."""

    def __init__(self, window, prepared, folder, patching) -> None:
        super().__init__(window, prepared, folder, patching)
        self.files_to_open = make_files(window, folder)
        patching.setattr(FileDialog, "open_file", lambda *asked: self._file_for(asked[1]))
        patching.setattr(FileDialog, "open_files", lambda *asked: [self._file_for(asked[1])])
        patching.setattr(FileDialog, "choose_folder", lambda *_asked: str(folder))

    def _file_for(self, title):
        return str(self.files_to_open.get(title, ""))

    def _prepare(self, scene, **_kwargs):
        return replace(pickle.loads(pickle.dumps(self.prepared)), scene=scene)

    @property
    def question(self):
        """Name of the question that is shown; None without one."""
        boxes = [box.objectName() for box in self.window.findChildren(QMessageBox) if box.isVisible()]
        return next((name for name in ("leave", "restore") if name in boxes), None)

    def edit(self):
        """The document after another edit that is not saved."""
        self.window.editor.do("Rotate", lambda document: rotate(document, [0], 0.1))
        assert self.window.presenters.map_files.unsaved
        return self.document

    def keeps(self, document):
        """Whether the document is still among the steps that can be undone or redone, also before another skin."""
        kept = [one.history for one in kept_documents(self.window)]
        return any(step.document is document for one in (self.window.editor.history, *kept) for step in one._steps)


def make_files(window, folder):
    """A file of each kind that the window opens, by the title of the dialog that asks for it."""
    folder = folder / "files"
    folder.mkdir()
    scene = load_scene("arm")
    (folder / "own.toml").write_text(scene_to_toml(scene))
    window.live.recording.start(folder / "touch.mcap")
    press_map(window, 5)
    run(window, 0.1)
    window.presenters.touch.release()
    run(window, 0.05)
    window.presenters.touch_script.save(str(folder / "script.toml"))
    window.live.recording.stop()
    save_document(window.editor.document, folder / "map.npz")
    write_taxels(window.live.prepared.skin, folder / "taxels.csv")
    shutil.copy(asset("findings", "loop-laws.csv"), folder / "study.csv")
    return {
        "Open robot": asset("robots", "arm", "arm.xml"),
        "Open scene": folder / "own.toml",
        "Open recording": folder / "touch.mcap",
        "Open map": folder / "map.npz",
        "Open study table": folder / "study.csv",
        "Import taxels": folder / "taxels.csv",
        "Play script": folder / "script.toml",
    }


@pytest.fixture
def bench(new_window, prepared, tmp_path, monkeypatch):
    new_window.resize(900, 600)
    new_window.robot_view.hide()  # it is most of what is drawn
    made = CarefulBench(new_window, prepared, tmp_path, monkeypatch)
    yield made
    made.tidy()


ASKING = ("open_robot", "open_scene", "package_root", "take_over", "quit")
"""Actions that replace the document and ask first."""
OTHERS = [name for name in EFFECTS if name not in ASKING]


@pytest.mark.parametrize(
    "names",
    [(*ASKING, *OTHERS[::12]), *(pytest.param(tuple(OTHERS[part::6]), marks=pytest.mark.long) for part in range(6))],
    ids=lambda names: f"{names[0]} and others",
)
def test_actions_ask_about_unsaved_edits(bench, names):
    lost = []
    asking = []
    for name in names:
        effect = EFFECTS[name]
        bench.live()
        document = bench.edit()
        effect.state(bench)
        if not bench.keeps(document):  # the state itself needs another document
            assert bench.window.editor.enabled, name
            document = bench.edit()
        bench.tidy()
        bench.window.presenters.state.update()
        bench.window.action(name).trigger()
        if bench.question is not None:
            asking.append(name)
            answer(bench.window, Button.Cancel, bench.question)
        run(bench.window, TICK)
        if not bench.keeps(document):
            lost.append(name)
        bench.tidy()
    assert not lost
    assert {*ASKING} & {*names} <= {*asking}


def test_dropped_files_ask_about_unsaved_edits(bench):
    for title, path in bench.files_to_open.items():
        bench.live()
        document = bench.edit()
        drop(bench.window, path)
        if bench.question is not None:
            answer(bench.window, Button.Cancel)
        run(bench.window, TICK)
        assert bench.keeps(document), title
        bench.tidy()


def test_scenes_of_the_menus_ask_about_unsaved_edits(bench):
    document = bench.edit()
    window = bench.window
    for open_one in (window.presenters.files.open_robot, window.presenters.files.open_shipped):
        open_one("arm")
        assert bench.question == "leave"
        answer(window, Button.Cancel)
    assert bench.keeps(document)
