"""Scenes in the File menu: the shipped ones by title, and the one that runs kept with what was chosen."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFileDialog, QMenu

from app.scene.scene_file import load_scene, scene_names
from tests.widgets.window_acts import run


def test_every_shipped_scene_is_offered_by_its_title(window, monkeypatch):
    opened = []
    monkeypatch.setattr(window.live, "open_scene", opened.append)
    menu = window.findChild(QMenu, "scenes")
    for _ in range(2):
        menu.aboutToShow.emit()
    assert len(menu.actions()) == len(scene_names()) + 2, "a line and the way to a file"
    for name in scene_names():
        item = window.findChild(QAction, f"scene-{name}")
        assert item.text() == (load_scene(name).title or name)
        item.trigger()
        assert opened[-1].name == load_scene(name).name
    assert len(opened) == len(scene_names()) >= 8


def test_a_scene_is_saved_with_the_effects_that_were_chosen(window, monkeypatch, tmp_path):
    window.column.effects.wished.emit("friction", "on")
    run(window, 0.02)
    path = tmp_path / "mine"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_args: (str(path), ""))
    window.action("save_scene").trigger()
    saved = path.with_suffix(".toml")
    assert str(saved) in window.message_bar.text
    assert str(saved) in window.settings.recent
    again = load_scene(str(saved))
    assert again.effects == window.live.runner.session.effects
    assert again == replace(window.effects.scene, name=again.name)


def test_a_scene_that_cannot_be_saved_says_why(window, tmp_path):
    window.scenes.save(str(tmp_path / "no such folder" / "scene.toml"))
    assert "cannot be written" in window.message_bar.text


def test_a_scene_of_ones_own_is_opened_from_its_file(window, monkeypatch, tmp_path):
    path = tmp_path / "own.toml"
    path.write_text('robot = "arm"\n[effects]\nfriction = "maybe"\n')
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_args: (str(path), ""))
    window.action("open_scene").trigger()
    assert "own.toml" in window.message_bar.text
    assert "maybe" in window.message_bar.text
    opened = []
    monkeypatch.setattr(window.live, "open_scene", opened.append)
    path.write_text('robot = "arm"\n[effects]\nfriction = "on"\n')
    window.action("open_scene").trigger()
    assert opened[0].effects.friction
