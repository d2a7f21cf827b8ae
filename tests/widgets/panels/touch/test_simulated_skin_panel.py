"""Simulated and measured skin side by side: the three maps, their texts, and the states without simulation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QObject, QPoint
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel

from tactile_maps.live.simulated_skin import SimulatedSkin
from tactile_maps.live.sources.open import SourceOptions
from tactile_maps.maps.build import build_map
from tactile_maps.scene.scene import Scene
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.jobs.executor import ProcessExecutor
from tactile_widgets.panels.touch.simulated_skin_panel import SimulatedSkinPanel
from tactile_widgets.session.backends import INLINE
from tactile_widgets.session.live_input import LiveInputSettings
from tactile_widgets.session.skin_comparison import SkinComparison
from tests.live.test_simulated_skin import frame_of
from tests.support.touch import pair
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import run

SLIDE = 0.032
"""Position of the pair's joint at which both covers are pressed [m]."""
DOUBLED = 7


@pytest.fixture(scope="module")
def meeting():
    """Two boxes whose covers meet, and what they read then [Pa]."""
    robot, skin = pair()
    prepared = PreparedScene(Scene(name="pair", robot="pair"), robot, skin, build_map(skin))
    return prepared, SimulatedSkin(prepared).pressures(np.array([SLIDE]))


@pytest.fixture
def window(window_again):
    """The shared window; the connection is closed after each test."""
    yield window_again
    window_again.live.connection.close()


def connected(window, tmp_path, meeting, *, unit="Pa", folded=False):
    """The panel, with readings of one reading that has a taxel doubled."""
    prepared, pressures = meeting
    values = pressures.copy()
    values[np.argsort(pressures)[-DOUBLED]] *= 2
    joint = prepared.robot.joints[0].name
    head = f"# unit: {unit}\ntime,{','.join(map(str, range(len(values))))},joint:{joint}\n"
    row = ",".join(f"{value!r}" for value in values.tolist())
    path = tmp_path / "readings.csv"
    path.write_text(head + "".join(f"{0.01 * k},{row},{SLIDE}\n" for k in range(3)))
    window.live.show_prepared(prepared)
    panel = window.column.get(SimulatedSkinPanel)
    panel.set_folded(folded)
    window.live.connection.open(LiveInputSettings(str(path), SourceOptions(speed=None)))
    window.live.runner.run_for(2.0)
    run(window, 0.2)
    return panel


def text(panel, name):
    return panel.findChild(QLabel, f"simulated-{name}").text().replace("\u202f", " ")


@pytest.mark.long
def test_taxel_with_twice_the_gain_is_found(window, tmp_path, meeting):
    prepared, pressures = meeting
    assert window.column.get(SimulatedSkinPanel).isHidden()
    panel = connected(window, tmp_path, meeting)
    assert panel.isVisible()
    odd = int(np.argsort(pressures)[-DOUBLED])
    extra = pressures[odd]
    areas = prepared.skin.areas
    assert text(panel, "largest") == f"+{1e-3 * extra:.2f} kPa at taxel {odd}"
    assert text(panel, "rms") == f"{1e-3 * extra / np.sqrt(len(pressures)):.2f} kPa"
    assert text(panel, "force") == f"{pressures @ areas + extra * areas[odd]:.2f}, {pressures @ areas:.2f} N"
    assert "the robot itself alone" in text(panel, "state")
    assert panel.view.scales[0] >= 1e-3 * max(pressures.max(), 2 * extra)


def test_hovered_taxel_is_described_and_a_click_selects_it(window, tmp_path, meeting):
    panel = connected(window, tmp_path, meeting)
    odd = int(np.argsort(meeting[1])[-DOUBLED])
    window.column.reveal(panel)
    place = panel.view.place_of(odd, 1).toPoint()
    QTest.mouseMove(panel.view, QPoint(1, 1))
    QTest.mouseMove(panel.view, place)
    assert f"axel {odd}: measured" in text(panel, "taxel")
    left_click(panel.view, place)
    assert window.views.selection.taxels.tolist() == [odd]


def test_dots_have_the_colours_of_their_scales(window, tmp_path, meeting):
    panel = connected(window, tmp_path, meeting)
    odd = int(np.argsort(meeting[1])[-DOUBLED])
    panel.resize(900, 600)
    panel.view.resize(880, panel.view.heightForWidth(880))
    image = panel.view.grab().toImage()
    measured, simulated, more = (image.pixelColor(panel.view.place_of(odd, k).toPoint()) for k in range(3))
    assert measured.lightness() < simulated.lightness()
    assert more.red() > more.blue()


@pytest.mark.long
def test_counts_are_rejected_with_an_explanation(window, tmp_path, meeting):
    panel = connected(window, tmp_path, meeting, unit="counts")
    assert "Calibrate the skin" in text(panel, "state")
    assert text(panel, "rms") == "–"


def test_folded_panel_does_not_simulate(window, tmp_path, meeting, monkeypatch):
    asked = []
    monkeypatch.setattr(type(window.live.skin_comparison), "compare", lambda *request: asked.append(request))
    panel = connected(window, tmp_path, meeting, folded=True)
    assert not asked
    assert text(panel, "rms") == "–"


@pytest.fixture
def comparison(qapp):
    parent = QObject()
    made = SkinComparison(replace(INLINE, executor=ProcessExecutor), parent)
    yield made
    made.close()


@pytest.mark.long
def test_newest_frame_is_compared_if_frames_arrive_faster_than_simulated(qtbot, meeting, comparison):
    prepared, pressures = meeting
    found = []
    comparison.compared.connect(found.append)
    for factor in (1.0, 2.0, 3.0):
        comparison.compare(prepared, frame_of(factor * pressures, SLIDE))
    qtbot.waitUntil(lambda: not comparison.executor.busy, timeout=30_000)
    assert [difference.measured.max() for difference in found] == [3 * pressures.max()]
    assert np.array_equal(found[0].simulated, pressures)


@pytest.mark.long
def test_scene_that_cannot_be_simulated_is_tried_once(qtbot, meeting, comparison):
    prepared, pressures = meeting
    broken = replace(prepared, robot=replace(prepared.robot, mjcf="<mujoco/>"))
    for _ in range(2):
        with qtbot.waitSignal(comparison.failed, timeout=30_000):
            comparison.compare(broken, frame_of(pressures, SLIDE))
    assert comparison.executor.pid is None
