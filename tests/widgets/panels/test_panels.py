"""The panels: true numbers with units, and only what the hand moved is changed."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDoubleSpinBox, QLabel, QTabBar

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.editing.document import MapDocument
from tactile_maps.maps.evaluation.quality import measure
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.common.colours import LIGHT
from tactile_widgets.common.guide_window import GuidePlace
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.panel import LabelledSlider, Panel
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.document.taxel_selection import TaxelSelection
from tactile_widgets.jobs.executor import InlineExecutor
from tactile_widgets.jobs.scene_jobs import SceneJobs
from tactile_widgets.panels.control.controller_panel import ControllerPanel
from tactile_widgets.panels.maps.quality_panel import QualityPanel
from tactile_widgets.panels.model.effects_panel import EffectsPanel
from tactile_widgets.panels.model.timing_panel import VIEW_STAGE, TimingPanel
from tactile_widgets.panels.panel_column import COLUMN_WIDTH, PanelColumn
from tactile_widgets.panels.registry import PANELS, PanelSpec, PanelTab
from tactile_widgets.panels.touch.contacts_panel import ContactsPanel
from tactile_widgets.session.backends import INLINE
from tactile_widgets.session.session_host import SessionHost
from tests.widgets.support.mouse import left_click


def shown(qtbot, panel):
    """A panel on the screen, gone after the test."""
    qtbot.addWidget(panel)
    panel.resize(300, 400)
    panel.show()
    return panel


def texts(panel):
    """All words and numbers of a panel that can be seen."""
    QApplication.processEvents()  # what was laid out just now is shown with the next events
    parts = [part for kind in (QLabel, QDoubleSpinBox) for part in panel.findChildren(kind)]
    return [part.text() for part in parts if part.isVisible() and part.text()]


@pytest.fixture
def touched(prepared):
    """A frame with one contact."""
    session = Session(prepared, scripted=False)
    session.submit(PokePressed(1, prepared.skin.taxel_point(70)))
    session.run_for(0.6)
    assert len(session.frame.regions) == 1
    return session.frame


def test_slider_returns_the_set_value(qtbot):
    slider = shown(qtbot, LabelledSlider("Gain", "N", 0.0, 10.0, 0.5, "tip"))
    for value in (0.0, 3.3, 10.0, 25.0, math.inf):
        slider.set_value(value)
        assert slider.value == value, "a slider shows the current setting without rounding or clipping"
    assert "∞" in texts(slider)[-1]


def test_slider_moves_by_keys(qtbot):
    slider = shown(qtbot, LabelledSlider("Gain", "N", 0.0, 10.0, 0.5, "tip"))
    got = []
    slider.value_changed.connect(got.append)
    slider.set_value(3.0)
    QTest.keyClick(slider._slider, Qt.Key.Key_Right)
    assert got == [3.5]
    assert "3.5\u202fN" in texts(slider)


def test_slider_reports_the_end_of_a_drag_when_released(qtbot):
    slider = shown(qtbot, LabelledSlider("Gain", "N", 0.0, 10.0, 0.5, "tip"))
    rested = []
    handle = slider._slider
    slider.rested.connect(rested.append)
    handle.setSliderDown(True)
    handle.setValue(4)
    handle.setValue(8)
    assert slider.held
    assert rested == []
    assert not slider._quiet.isActive(), "however long the hand waits"
    handle.setSliderDown(False)
    assert rested == [4.0]
    handle.setSliderDown(True)
    handle.setSliderDown(False)
    assert rested == [4.0], "taken and left where it was"
    for _ in range(3):
        QTest.keyClick(handle, Qt.Key.Key_Right)
    qtbot.waitUntil(lambda: not slider.held)
    assert rested == [4.0, 5.5]


def test_slider_of_differing_values_shows_no_number(qtbot):
    slider = shown(qtbot, LabelledSlider("Gain", "N", 0.0, 10.0, 0.5, "tip"))
    slider.set_mixed()
    assert texts(slider) == ["Gain", "—"]
    slider.set_value(5.0)
    assert texts(slider) == ["Gain", "5.0\u202fN"]


def test_heading_folds_its_panel(qtbot):
    panel = shown(qtbot, TimingPanel())
    folded = []
    panel.folded_changed.connect(folded.append)
    assert "Real time" in texts(panel)
    tall = panel.sizeHint().height()
    left_click(panel._heading)
    assert folded == [True]
    assert texts(panel) == []
    assert panel.sizeHint().height() < tall / 2
    panel._heading.setFocus()
    QTest.keyClick(panel._heading, Qt.Key.Key_Space)
    assert folded == [True, False]
    panel.set_folded(True)
    assert panel.folded
    assert folded == [True, False], "only folding by the user is reported"


@pytest.fixture
def column(qtbot, prepared):
    editor = MapEditor(SceneJobs(InlineExecutor("prepare")))
    editor.open(MapDocument.of(prepared.map))
    editor.set_enabled(enabled=True)
    made = PanelColumn(editor)
    qtbot.addWidget(made)
    made.resize(made.width(), 600)
    made.show_prepared(prepared)
    made.show()
    qtbot.waitExposed(made)
    QApplication.processEvents()
    return made


@pytest.mark.long
def test_column_reports_folded_panels(column):
    at_first = (
        "skin-check-panel",
        "simulated-skin-panel",
        "wanted-motion-panel",
        "behaviours-panel",
        "posture-panel",
        "compare-panel",
        "accuracy-panel",
        "messages-panel",
    )
    assert column.folded == at_first
    orders = []
    column.folded_changed.connect(orders.append)
    left_click(column["contacts"]._heading)
    assert orders == [(*at_first[:3], "contacts-panel", *at_first[3:])]
    column.set_folded(["timing-panel", "a panel of another version"])
    assert column.folded == ("timing-panel",)
    assert len(orders) == 1


@pytest.mark.long
def test_folded_panel_out_of_sight_is_revealed(column):
    orders = []
    column.folded_changed.connect(orders.append)
    column.set_folded(["timing-panel"])
    column.reveal(column["timing"])
    assert column.folded == orders[0] == ()
    QApplication.processEvents()
    assert column.tab is PanelTab.MODEL
    page = column.page_of(column["timing"]).viewport()
    assert page.rect().contains(column["timing"].mapTo(page, column["timing"].rect().topLeft()))


def test_panel_higher_than_the_page_is_revealed_from_its_top(column):
    column.resize(COLUMN_WIDTH, 200)
    column.reveal(column["effects"])
    QApplication.processEvents()
    page = column.page_of(column["effects"]).viewport()
    assert column["effects"].height() > page.height()
    assert column["effects"].mapTo(page, QPoint(0, 0)).y() == 0


@pytest.mark.long
def test_all_panels_fit_the_column(column):
    column.set_folded(())
    for panel in column:
        column.reveal(panel)
        QApplication.processEvents()
        content = column.page_of(panel).widget()
        assert content.minimumSizeHint().width() <= COLUMN_WIDTH - 8, "a scroll bar must fit next to them"


def test_panels_of_a_tab_are_in_the_order_of_their_registration(column):
    for tab in PanelTab:
        own = [panel for panel, spec in zip(column, PANELS, strict=True) if spec.tab is tab]
        rows = [column.page_of(panel).widget().layout().indexOf(panel) for panel in own]
        assert rows == list(range(len(own)))


def test_tab_of_a_connected_skin_is_shown_while_it_is_connected(column):
    def visible():
        tabs = column.findChild(QTabBar)
        return [tabs.tabText(k) for k in range(tabs.count()) if tabs.isTabVisible(k)]

    assert visible() == ["Touch", "Control", "Map", "Model"]
    column.show_tab(PanelTab.MAP)
    column.set_live(live=True)
    assert visible() == ["Live", "Touch", "Control", "Map", "Model"]
    assert column.tab is PanelTab.LIVE
    column.set_live(live=False)
    assert column.tab is PanelTab.MAP
    column.set_live(live=True)
    column.show_tab(PanelTab.TOUCH)
    column.set_live(live=False)
    assert column.tab is PanelTab.TOUCH, "the user had left the tab"


class Extra(Panel):
    """Keeps what reaches it."""

    def __init__(self):
        super().__init__("Extra", "extra-panel")
        self.got = []

    def show_prepared(self, prepared):
        self.got.append(prepared)

    def show_frame(self, frame):
        self.got.append(frame)

    def set_editable(self, *, editable):
        self.got.append(editable)

    def set_theme(self, theme):
        self.got.append(theme)


@pytest.mark.long
def test_panel_is_registered_in_one_line(qtbot, editor, prepared, touched):
    """Its place, scenes, frames, theme, session and folding come from its spec and the hooks."""
    session = SessionHost(backends=INLINE)
    selection = TaxelSelection()
    followed = []
    specs = (
        PANELS[4],
        PanelSpec(
            PanelTab.TOUCH,
            lambda _editor, _panels: Extra(),
            GuidePlace("index"),
            lambda *parts: followed.append(parts),
            folded_at_first=True,
        ),
        PANELS[5],
    )
    column = PanelColumn(editor, specs=specs)
    qtbot.addWidget(column)
    column.follow(session, selection)
    panel = column.get(Extra)
    assert panel is column["extra"]
    assert followed == [(panel, session, selection)]
    assert column.folded == ("extra-panel",)
    column.show_prepared(prepared)
    column.show_frame(touched)
    column.set_theme(LIGHT)
    session.mode_changed.emit(Mode.REPLAYING)
    assert panel.got == [True, prepared, touched, LIGHT, False], "True without a session: it does not simulate"
    column.show()
    QApplication.processEvents()
    assert column["contacts"].y() < panel.y() < column["events"].y()
    session.close()


@pytest.mark.parametrize(
    ("settings", "moved", "kept"),
    [
        (ControlSettings(stiffness=50.0), "damping_ratio", "stiffness"),
        (ControlSettings(controller="hold_force", integral_time=math.inf), "force_gain", "integral_time"),
        (ControlSettings(controller="hold_force", force_goal=3.3), "force_gain", "force_goal"),
    ],
)
def test_moving_a_slider_changes_only_its_gain(qtbot, settings, moved, kept):
    panel = shown(qtbot, ControllerPanel())
    panel.show_settings(settings)
    got = []
    panel.settings_edited.connect(got.append)
    QTest.keyClick(panel.sliders.by_name[moved]._slider, Qt.Key.Key_Right)
    assert getattr(got[0], moved) > getattr(settings, moved)
    assert getattr(got[0], kept) == getattr(settings, kept)


def test_controller_shows_its_own_gains(qtbot):
    panel = shown(qtbot, ControllerPanel())
    got = []
    panel.settings_edited.connect(got.append)
    left_click(panel._buttons["hold_force"])
    assert got[0].controller == "hold_force"
    assert panel.sliders.by_name["force_goal"].isVisible()
    assert not panel.sliders.by_name["stiffness"].isVisible()


@pytest.mark.long
def test_limits_of_the_controller_are_shown(qtbot, touched):
    panel = shown(qtbot, ControllerPanel())
    panel.show_frame(replace(touched, why_limited=(Limit(LimitKind.JOINT_LIMIT, ("elbow",)),)))
    assert "Limited: joint limit: elbow" in texts(panel)
    panel.show_frame(replace(touched, time=touched.time + 2.0, why_limited=()))
    assert "Not limited" in texts(panel)


@pytest.mark.long
def test_contacts_are_listed_with_units_and_cleared(qtbot, touched):
    panel = shown(qtbot, ContactsPanel())
    assert any("No contact." in text for text in texts(panel))
    panel.show_frame(touched)
    region = touched.regions[0]
    words = texts(panel)
    assert {"On", "N", "kPa", "mm²"} <= set(words)
    place = words.index(region.link)
    facts = panel.findChild(QLabel, "contacts-facts").text()
    assert words[place : place + 4] == [
        region.link,
        f"{region.force:.2f}",
        f"{1e-3 * region.peak:.1f}",
        f"{1e6 * region.area:.0f}",
    ]
    assert f"{region.force:.2f} ± {region.force_error:.2f}\u202fN" in facts
    assert f"± {1e3 * region.place_error:.1f}\u202fmm" in facts
    panel.clear()
    assert region.link not in texts(panel)


def test_effects_panel_states_active_effects_with_reasons(qtbot, prepared):
    panel = shown(qtbot, EffectsPanel())
    panel.show_prepared(prepared)
    panel.show_prepared(prepared)
    qtbot.waitUntil(lambda: texts(panel).count("Gravity") == 1)  # rows added to a panel in sight are shown a turn later
    assert panel.lines["gravity"].words[1] == "off"
    assert all(line.toolTip() for line in panel.lines.values())


@pytest.mark.long
def test_quality_panel_is_empty_then_measuring_then_filled(qtbot, coarse_prepared):
    prepared = coarse_prepared
    panel = shown(qtbot, QualityPanel())
    assert any("Open a robot" in text for text in texts(panel))
    panel.show_prepared(prepared)
    assert "Measuring…" in texts(panel)
    panel.show_quality(measure(prepared.map))
    assert "Measuring…" not in texts(panel)
    assert panel.findChild(QLabel, "quality-bijective").text() == "yes"
    assert panel.findChild(QLabel, "quality-taxels").text() == str(len(prepared.skin))


@pytest.mark.long
def test_timing_panel_shows_stage_times_and_real_time_factor(qtbot, touched):
    panel = shown(qtbot, TimingPanel())
    for milliseconds in (1.0, 2.0, 9.0):
        panel.add(VIEW_STAGE, milliseconds)
    panel.show_factor(0.97)
    panel.show_frame(touched)
    names = [panel._grid.itemAtPosition(row, 0).widget().text() for row in range(panel._grid.rowCount())]
    assert names == ["Real time", "Physics", "Touch", "Sensor", "Contacts", "Control", "3-D view"]
    assert panel.findChild(QLabel, f"timing-{VIEW_STAGE}").text() == "2.00\u202fms"
    assert panel.findChild(QLabel, "timing-factor").text() == "0.97×"
    panel.clear()
    assert panel.findChild(QLabel, f"timing-{VIEW_STAGE}").text() == "–"


def test_stage_that_ended_before_it_was_listed_is_dropped(qtbot, touched):
    panel = shown(qtbot, TimingPanel())
    panel.add("receive", 1.0)
    panel.show_frame(touched)
    panel.refresh()
    assert panel.findChild(QLabel, "timing-receive") is None


def test_number_next_to_a_slider_can_be_typed_within_its_limits(qtbot):
    slider = shown(qtbot, LabelledSlider("Gain", "N", 0.0, 10.0, 0.5, "tip"))
    got = []
    rested = []
    slider.value_changed.connect(got.append)
    slider.rested.connect(rested.append)
    field = slider._value
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "7.2")
    assert got == [], "not at every letter"
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert (got, rested, slider.value) == ([7.2], [7.2], 7.2)
    assert slider._slider.value() == 14
    field.selectAll()
    QTest.keyClicks(field, "99")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert slider.value <= 10.0
    assert "0 to 10" in field.toolTip()
