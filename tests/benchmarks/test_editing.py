"""Editing in the real window: undo, quality after an edit, hover, and frame rates of map and 3-D view.

.venv/bin/python -m pytest tests/benchmarks/test_editing.py --benchmark-enable
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QEventLoop, QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.editing.arrange import rotate
from tactile_maps.editing.reflatten import apply_result, reflatten, set_lengths
from tactile_maps.scene.scene_file import load_scene, scene_for
from tactile_maps.session.prepare import prepare
from tactile_maps.studies.testbeds.reference_bodies import closed_link
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import DARK
from tactile_widgets.common.settings import Settings
from tactile_widgets.jobs.executor import ProcessExecutor
from tactile_widgets.session.backends import INLINE
from tactile_widgets.session.session_runner import ThreadRunner
from tactile_widgets.window.main_window import MainWindow

SECONDS = 5.0
MOVE_SECONDS = 0.02
"""Time between mouse moves [s]."""


@pytest.fixture(scope="module")
def prepared():
    return prepare(load_scene("arm"))


@pytest.fixture
def open_window(qtbot, tmp_path, monkeypatch):
    """Return a function that opens windows, which are closed at the end."""
    monkeypatch.setattr(
        "tactile_widgets.presenters.maps.map_file_presenter.user_state_path",
        lambda *_args, **_kwargs: tmp_path / "state",
    )
    apply_theme(QApplication.instance(), DARK)
    opened = []

    def opening(prepared, backends=INLINE):
        window = MainWindow(Settings(tmp_path / "window.ini"), backends=backends)
        window.resize(1400, 900)
        window.show()
        qtbot.waitExposed(window)
        window.live.show_prepared(prepared)
        opened.append(window)
        return window

    yield opening
    for window in opened:
        window.presenters.map_files.give_up()
        window.close()
        window.deleteLater()


@pytest.mark.parametrize("kind", ["layout", "chart"])
def test_undo_until_painted(benchmark, prepared, open_window, kind):
    window = open_window(prepared)
    editor = window.editor
    if kind == "layout":
        editor.do("Rotate", lambda document: rotate(document, [1], 0.3))
    else:
        editor.ask(lambda document: set_lengths(document, [1], 0.5))
    assert len(editor.history.names) == 2

    def back():
        (window.action("undo") if editor.history.position else window.action("redo")).trigger()
        window.map_view.viewport().repaint()

    benchmark.pedantic(back, rounds=30, warmup_rounds=4)


@pytest.mark.parametrize("kind", ["layout", "chart"])
def test_quality_after_an_edit(benchmark, prepared, open_window, qtbot, kind):
    """Measure the time from an edit to the new numbers on the card, including the process that computes them."""
    window = open_window(prepared, replace(INLINE, executor=ProcessExecutor))
    with qtbot.waitSignal(window.live.measurements.measured, timeout=60_000):
        pass
    result = reflatten(set_lengths(window.editor.document, [1], 0.5))
    edits = {
        "layout": lambda document: rotate(document, [1], 0.1),
        "chart": lambda document: apply_result(document, result),
    }
    window.editor.do("Edit", edits[kind])
    with qtbot.waitSignal(window.live.measurements.measured, timeout=60_000):
        pass

    def edit():
        with qtbot.waitSignal(window.live.measurements.measured, timeout=60_000):
            (window.action("undo") if window.editor.history.position else window.action("redo")).trigger()

    benchmark.pedantic(edit, rounds=20, warmup_rounds=2)


@pytest.mark.parametrize("where", ["map", "robot"])
def test_hover_until_the_other_view_shows_it(benchmark, prepared, open_window, where):
    window = open_window(prepared)
    view = window.map_view if where == "map" else window.robot_view
    surface = view.viewport() if where == "map" else view.display.canvas.widget
    skin = prepared.skin
    other = window.map_view if where == "robot" else window.robot_view
    seen = [k for k in range(0, len(skin), 25) if view.rect().contains(view.pixel_of(skin.taxel_point(k)).toPoint())]
    places = iter(seen * 50)

    def hover():
        pixel = view.pixel_of(skin.taxel_point(next(places))).toPoint()
        QTest.mouseMove(surface, pixel + QPoint(1, 0))
        if where == "robot":
            other.viewport().repaint()
        else:
            other.display.draw_now()

    benchmark.pedantic(hover, rounds=60, warmup_rounds=5)


@pytest.fixture(scope="module")
def scan(tmp_path_factory, pytestconfig):
    """Return a closed body of 200,000 vertices with skin; a small one if nothing is measured."""
    path = tmp_path_factory.mktemp("scan") / "scan.off"
    mesh = closed_link(400_000 if pytestconfig.getoption("benchmark_enable") else 4_000)
    rows = [" ".join(map(repr, row)) for row in mesh.vertices.tolist()]
    faces = [f"3 {a} {b} {c}" for a, b, c in mesh.faces.tolist()]
    path.write_text("\n".join(["OFF", f"{len(rows)} {len(faces)} 0", *rows, *faces]))
    scene = scene_for(str(path))
    return prepare(replace(scene, cover=replace(scene.cover, taxels=1000)))


def circle(prepared, radius=0.012, count=125):
    """Return the skin points of a circle [m] on the map, where they exist."""
    middle = prepared.map.to_map(prepared.skin.taxel_point(len(prepared.skin) // 2))
    angles = np.arange(count) * 2 * np.pi / count
    places = [prepared.map.to_body(middle + radius * np.array([np.cos(a), np.sin(a)])) for a in angles]
    return [place for place in places if place is not None]


def drawn_by(window):
    """Return the name of the renderer: a graphics card, or software."""
    said = window.robot_view.display.canvas.plotter.render_window.ReportCapabilities()
    return next(line.split(":")[1].strip() for line in said.splitlines() if "renderer string" in line)


@pytest.mark.parametrize("gesture", ["a finger presses", "a finger is dragged", "the robot is turned"])
@pytest.mark.parametrize("body", ["arm, 20,000 vertices", "scan, 200,000 vertices"])
def test_frame_rate_of_both_views(benchmark, request, open_window, body, gesture):
    """Count painted maps and drawn bodies in five seconds of wall time."""
    prepared = request.getfixturevalue("prepared" if body.startswith("arm") else "scan")
    window = open_window(prepared, replace(INLINE, runner=ThreadRunner))
    painted = []
    drawn = []
    window.map_view.painted.connect(lambda _tick: painted.append(time.perf_counter()))
    window.robot_view.display.drawn.connect(drawn.append)
    places = circle(prepared)
    surface = window.robot_view.display.canvas.widget
    if gesture != "the robot is turned":
        window.presenters.touch.press(places[0])

    def go_on(step):
        if gesture == "a finger is dragged":
            window.presenters.touch.move(places[step % len(places)])
        elif gesture == "the robot is turned":
            QTest.mouseMove(surface, QPoint(30 + 3 * step % 300, 40))

    def run():
        painted.clear()
        drawn.clear()
        start = time.perf_counter()
        step = 0
        if gesture == "the robot is turned":
            QTest.mousePress(surface, Qt.MouseButton.LeftButton, pos=QPoint(30, 40))
        while (elapsed := time.perf_counter() - start) < (SECONDS if benchmark.enabled else 0.2):
            if elapsed > step * MOVE_SECONDS:
                step += 1
                go_on(step)
            QApplication.processEvents(QEventLoop.ProcessEventsFlag.WaitForMoreEvents)
        QTest.mouseRelease(surface, Qt.MouseButton.LeftButton, pos=QPoint(30, 40))

    benchmark.pedantic(run, rounds=1)
    gaps = 1e3 * np.diff(painted) if len(painted) > 1 else [float("nan")]
    benchmark.extra_info |= {
        "drawn by": drawn_by(window),
        "maps a second": round(len(painted) / SECONDS, 1),
        "gap, median and 95 % [ms]": [round(float(np.percentile(gaps, share)), 1) for share in (50, 95)],
        "bodies a second": round(len(drawn) / SECONDS, 1),
        "body [ms]": round(float(np.median(drawn)), 1) if drawn else None,
        "real time": round(window.live.runner.real_time_factor, 2),
    }
    window.live.runner.stop()
