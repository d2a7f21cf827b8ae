"""Force estimation in the contacts panel: choices of the user, and the description of the estimate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QInputDialog, QLabel, QScrollBar

from tactile_maps.contacts.detection.contact_shear import ContactShear, Slip
from tactile_maps.contacts.force_estimation.estimate import ESTIMATORS, EstimateRefusal, ForceEstimate
from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.motion.command import TaskReport
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.scene.effects import Effects
from tactile_maps.session.session import Session
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind
from tactile_maps.tactile.poke import PokePressed
from tactile_maps.tactile.sensors.sensor_effects import Noise, SensorEffects
from tactile_widgets.panels.touch.contacts_panel import ESTIMATORS as WORDS
from tactile_widgets.panels.touch.contacts_panel import (
    SHEAR_TIP,
    ContactsPanel,
    EstimationControls,
    estimate_text,
    uncertainty_text,
)
from tactile_widgets.views.overlays.task_overlay import NO_TASK
from tests.widgets.support.samples import leaf_map, touched

ESTIMATE = ForceEstimate(
    2.0, None, np.arange(14), np.full(14, 1 / 7), 4.12, 12, 14, 110.0, 100.0, peak=41_000.0, mean=12_300.0
)
REFUSED = replace(ESTIMATE, taxels=np.zeros(0), forces=np.zeros(0), effective_rank=3, refused=EstimateRefusal.RANK)


@pytest.fixture
def box(qtbot):
    made = EstimationControls()
    qtbot.addWidget(made)
    made.show()
    return made


@pytest.fixture
def panel(qtbot):
    made = ContactsPanel()
    qtbot.addWidget(made)
    made.setFixedWidth(292)
    made.show()
    return made


def choose(choice, steps: int) -> None:
    """Choose with the keys, like a user."""
    choice.setFocus()
    for _ in range(abs(steps)):
        QTest.keyClick(choice, Qt.Key.Key_Down if steps > 0 else Qt.Key.Key_Up)


def test_every_estimator_is_offered_with_its_cost_and_loss(box):
    assert tuple(WORDS) == ESTIMATORS
    assert [box.estimator.itemData(row) for row in range(box.estimator.count())] == list(ESTIMATORS)
    assert all(box.estimator.itemData(row, Qt.ItemDataRole.ToolTipRole) for row in range(len(ESTIMATORS)))


def test_user_chooses_an_estimator_and_a_threshold(qtbot, box):
    edited: list[ReadingSettings] = []
    box.reading_edited.connect(edited.append)
    choose(box.estimator, 2)
    assert edited[-1] == ReadingSettings("tikhonov")
    assert box.estimator.words == WORDS["tikhonov"][0]
    assert WORDS["tikhonov"][1] in box.estimator.toolTip()
    choose(box.threshold, 1)
    assert edited[-1] == ReadingSettings("tikhonov", 500.0)
    assert box.threshold.words == "Contact threshold 0.5\u202fkPa"
    choose(box.threshold, -1)
    assert edited[-1].threshold is None


def test_current_settings_are_shown_without_a_request(box):
    edited: list[ReadingSettings] = []
    box.reading_edited.connect(edited.append)
    box.show_reading(ReadingSettings("lumped", 1234.0, wrench_noise=0.1))
    assert box.estimator.words == WORDS["lumped"][0]
    assert box.threshold.words == "Contact threshold 1.23\u202fkPa"
    assert edited == []
    choose(box.estimator, -1)
    assert edited == [ReadingSettings("tikhonov", 1234.0, wrench_noise=0.1)], "the rest stays"


def test_choosing_the_current_value_makes_no_request(box):
    edited: list[ReadingSettings] = []
    box.reading_edited.connect(edited.append)
    box.estimator.activated.emit(0)
    box.threshold.activated.emit(0)
    assert edited == []


def test_automatic_threshold_states_its_value_for_the_current_noise(box):
    assert box.threshold.words == "Contact threshold 1\u202fkPa, automatic"
    box.show_effects(Effects(sensor=SensorEffects(noise=Noise(2000.0))))
    assert box.threshold.words == "Contact threshold 6\u202fkPa, automatic"
    assert box.threshold.itemText(0) == box.threshold.words


def test_counts_have_their_own_thresholds(box):
    edited: list[ReadingSettings] = []
    box.reading_edited.connect(edited.append)
    box.set_units(ReadingUnits.COUNTS, measured=True)
    assert box.threshold.words == "Automatic threshold ≥ 1\u202fcounts"
    rows = range(1, box.threshold.count() - 1)
    assert [box.threshold.itemData(row) for row in rows] == [1e3, 3e3, 1e4, 3e4, 1e5, 3e5, 1e6, 3e6, 1e7]
    choose(box.threshold, 7)
    assert edited[-1].threshold == 1e6
    assert box.threshold.words == "Contact threshold 1,000\u202fcounts"
    box.set_units(ReadingUnits.CALIBRATED)
    assert box.threshold.words == "Contact threshold 1,000\u202fkPa"


def test_any_other_threshold_can_be_entered(qtbot, box):
    edited: list[ReadingSettings] = []
    box.reading_edited.connect(edited.append)
    box.set_units(ReadingUnits.COUNTS, measured=True)
    for value, finish in ((2345.0, "accept"), (77.0, "reject")):
        box.threshold.activated.emit(box.threshold.count() - 1)
        dialog = box.findChild(QInputDialog, "ask-threshold")
        assert "(counts)" in dialog.labelText()
        assert dialog.doubleMaximum() >= 2**24
        dialog.setDoubleValue(value)
        with qtbot.waitSignal(dialog.destroyed):
            getattr(dialog, finish)()
    assert [settings.threshold for settings in edited] == [2.345e6]
    assert box.threshold.words == "Contact threshold 2,345\u202fcounts"
    assert box.threshold.currentIndex() == -1


def test_quality_of_the_force_estimate_is_described_in_words():
    assert estimate_text(ESTIMATE) == (
        "Effective rank 12/14, residual 1.1\u202f×\u202fnoise\nCondition 4.1, peak 41.0 and mean 12.3\u202fkPa"
    )
    assert "residual 0.11\u202fkPa" in estimate_text(replace(ESTIMATE, noise=0.0))
    head, why = estimate_text(REFUSED).split("\n")
    assert head == "Effective rank 3/14, condition 4.1"
    assert why.startswith("Rejected: the effective rank is too low")
    assert len({estimate_text(replace(REFUSED, refused=reason)) for reason in EstimateRefusal}) == len(EstimateRefusal)
    lumped = ForceEstimate(2.0, None, effective_rank=6, unknowns=6)
    assert estimate_text(lumped).startswith("Wrench: effective rank 6/6")
    assert "∞" in estimate_text(replace(ESTIMATE, condition=float("inf")))
    assert "1e+05" in estimate_text(replace(ESTIMATE, condition=1.2e5))


@pytest.mark.long
def test_panel_shows_estimate_quality_and_greys_out_failed_estimates(panel, prepared):
    session = Session(prepared, reading=ReadingSettings("tikhonov"))
    session.submit(PokePressed(1, prepared.skin.taxel_point(30)))
    for _ in range(100):
        session.tick()
    frame = session.frame
    label = panel.findChild(QLabel, "contacts-estimate")
    (number,) = (region.id for region in frame.regions)
    panel.show_frame(frame)
    assert not label.isVisible(), "the area sum has no such quality"
    panel.show_reading(session.runtime_settings.reading)
    panel.show_frame(frame)
    assert label.isVisible()
    assert label.isEnabled()
    assert label.text() == estimate_text(frame.estimates[number])
    assert "ffective rank" in panel.findChild(type(panel._rows[0].button), "contact-1").toolTip()
    height = label.height()
    panel.show_frame(replace(frame, estimates={number: REFUSED}))
    assert not label.isEnabled()
    assert "too deep" in label.text()
    panel.clear()
    QApplication.processEvents()
    assert label.height() == height, "the layout below does not jump"
    assert label.text() == ""


def test_tool_tip_of_a_contact_has_its_estimate(panel, prepared):
    frame = touched(prepared.map, (30,))
    button = panel.findChild(type(panel._rows[0].button), "contact-1")
    panel.show_frame(frame)
    assert estimate_text(ESTIMATE) not in button.toolTip()
    panel.show_frame(replace(frame, estimates={frame.regions[0].id: ESTIMATE}))
    assert estimate_text(ESTIMATE) in button.toolTip()


def test_largest_part_of_the_uncertainty_is_named(panel, prepared):
    frame = touched(prepared.map, (30,))
    facts = panel.findChild(QLabel, "contacts-facts")
    parts = {"noise": 0.1, "hysteresis": 0.35, "ring": 0.2, "gain_spread": 0.0}
    limits = {"noise": 0.2, "hysteresis": 0.7, "ring": 0.4, "gain_spread": 0.0}
    region = replace(frame.regions[0], force_error=0.42, force_parts=parts, force_limits=limits)
    low, high = region.force_interval
    assert region.force - low < high - region.force
    panel.show_frame(replace(frame, regions=(region,)))
    assert facts.text().startswith(f"{region.force:.2f} ± 0.42")
    assert facts.toolTip().startswith(
        "Uncertainty of the force mostly from hysteresis:\n"
        "hysteresis 0.35\u202fN, force outside the ring 0.20\u202fN, noise 0.10\u202fN\n"
        f"With a probability of 95 % between {low:.2f} and {high:.2f}\u202fN\n\nThe selected contact"
    )
    panel.show_frame(frame)
    assert facts.toolTip().startswith("The selected contact"), "recordings may not store the parts"
    assert uncertainty_text(region, ReadingUnits.COUNTS) == ""


def test_force_of_a_saturated_contact_is_a_lower_bound(panel, prepared):
    frame = touched(prepared.map, (30,))
    facts = panel.findChild(QLabel, "contacts-facts")
    for lost, first in ((0.0, f"{frame.regions[0].force:.2f} ±"), (0.5, f"At least {frame.regions[0].force:.2f} ±")):
        region = replace(frame.regions[0], force_error=lost, force_parts={"saturation": lost})
        panel.show_frame(replace(frame, regions=(region,)))
        assert facts.text().startswith(first)


def test_force_missed_below_the_threshold_is_stated_with_its_share(panel, prepared):
    frame = touched(prepared.map, (30,))
    region = frame.regions[0]
    facts = panel.findChild(QLabel, "contacts-facts")
    summary = panel.findChild(QLabel, "contacts-summary")
    note = ContactNote(ContactNoteKind.BELOW_THRESHOLD, ("book", region.link), force=6.87, pressure=2e3, threshold=2e3)
    lacking = replace(note, share=0.38)
    panel.show_frame(replace(frame, notes=(lacking,)))
    assert facts.text().split("\n")[2:] == ["Lacks 38\u202f% of the force: below the threshold"]
    assert facts.fontMetrics().horizontalAdvance(facts.text().split("\n")[2]) <= facts.width()
    assert NO_TASK.force_words(region, frame.units, (lacking,)) == f"≥\u202f{NO_TASK.force_words(region, frame.units)}"
    other = replace(lacking, bodies=("another_link",))
    panel.show_frame(replace(frame, notes=(other,)))
    assert len(facts.text().split("\n")) == 2
    assert NO_TASK.force_words(region, frame.units, (other,)) == NO_TASK.force_words(region, frame.units)
    panel.show_frame(replace(frame, regions=(), notes=(replace(note, bodies=("book", "left_hand")),)))
    assert summary.text() == "No contact: 6.87\u202fN on left hand is below the threshold."
    panel.show_frame(replace(frame, regions=()))
    assert summary.text() == "No contact. Press the skin in a view."


def test_sum_of_depths_is_shown_without_an_accuracy(panel, prepared):
    frame = touched(prepared.map, (30,))
    facts = panel.findChild(QLabel, "contacts-facts")
    parts = {"noise": 0.1, "contact_model": float("inf")}
    region = replace(frame.regions[0], force_error=float("inf"), force_parts=parts)
    panel.show_frame(replace(frame, regions=(region,)))
    assert facts.text().startswith(f"{region.force:.2f}\u202fN of unknown accuracy, centre")
    assert "contact model ∞, noise 0.10" in facts.toolTip()
    assert "No upper limit: depths are not pressures" in facts.toolTip()


def test_unobservable_force_is_stated_in_weak_text(panel):
    line = panel.findChild(QLabel, "contacts-shear")
    assert line.text() == "Net shear is unobservable"
    assert line.property("role") == "caption"
    assert line.toolTip() == SHEAR_TIP


def test_columns_of_shear_appear_while_frames_have_shear(panel, prepared):
    frame = touched(prepared.map, (30,))
    shear = ContactShear((3.0, 0.0, 4.0), 2e-3, 0.86, 0.6, Slip.INCIPIENT, 0.5, estimated=False, force_error=0.1)
    region = replace(frame.regions[0], shear=shear)

    def texts():
        return [label.text() for label in panel.findChildren(QLabel) if label.isVisible()]

    panel.show_frame(frame)
    QApplication.processEvents()
    narrow = panel.minimumSizeHint().width()
    for slip, usage, text in (
        (Slip.STICKING, 0.42, "42\u202f%"),
        (Slip.INCIPIENT, 0.86, "◐\u202f86\u202f%"),
        (Slip.SLIDING, 1.0, "slides"),
    ):
        sheared = replace(region, link="left_forearm_link", shear=replace(shear, slip=slip, usage=usage))
        panel.show_frame(replace(frame, regions=(sheared,), shear=np.zeros((len(prepared.skin), 2))))
        assert {"shear", "5.00", "friction", text} <= set(texts())
        assert "Net shear is unobservable" not in texts()
        assert "Shear 5.00 ± 0.10\u202fN" in panel._rows[0].button.toolTip()
        QApplication.processEvents()
        assert panel.minimumSizeHint().width() <= 292
        name = panel._rows[0]._cells[1]
        assert name.fontMetrics().horizontalAdvance(name.shown) <= name.width()
        assert len(name.shown) >= len("lef…nk"), "a name is shortened, never to its first letter"
    panel.show_frame(frame)
    assert not {"shear", "friction", "5.00"} & set(texts())
    assert "Net shear is unobservable" in texts()
    QApplication.processEvents()
    assert panel.minimumSizeHint().width() == narrow


def test_link_name_is_not_elided_once_the_panel_is_wide_enough(panel, prepared):
    frame = touched(prepared.map, (30,))
    region = replace(frame.regions[0], link="left_forearm_link_of_the_second_robot")
    panel.show_frame(replace(frame, regions=(region,)))
    QApplication.processEvents()
    name = panel._rows[0]._cells[1]
    assert "…" in name.shown
    panel.setFixedWidth(600)  # no frame follows: the session is paused
    QApplication.processEvents()
    assert name.shown == region.link


def test_contact_settings_are_disabled_in_a_replay(panel):
    panel.set_editable(editable=False)
    assert not panel.reading.isEnabled()
    assert panel._rows[0].button.isVisible()
    panel.set_editable(editable=True)
    assert panel.reading.isEnabled()


@pytest.mark.long
def test_choice_reaches_a_running_session_at_once_and_a_paused_one_after_a_reset(window, qtbot):
    live = window.live
    reading = window.column["contacts"].reading
    live.set_paused(paused=True)
    choose(reading.estimator, 2)
    live.step()
    assert live.runner.session.runtime_settings.reading.estimator == "tikhonov"
    choose(reading.threshold, 3)
    live.reset()
    live.step()
    assert live.runner.session.runtime_settings.reading == ReadingSettings("tikhonov", 2000.0)
    assert reading.threshold.words == "Contact threshold 2\u202fkPa"


def test_seven_contacts_can_all_be_scrolled_to(panel, prepared, qtbot):
    """Three rows are visible; the scroll bar reaches the rest, a selected row becomes visible, and no row moves."""
    tall = panel.sizeHint().height()
    panel.show_frame(touched(prepared.map, [8 * k for k in range(1, 8)]))
    links = [region.id for region in panel._regions]
    assert len(links) == 7
    bar = panel.findChild(QScrollBar, "contacts-scroll")
    assert bar.isVisible()
    assert panel.sizeHint().height() == tall
    seen = set()
    bar.setFocus()
    for _ in range(5):
        seen |= {row.region for row in panel._rows}
        QTest.keyClick(bar, Qt.Key.Key_Down)
    assert seen == set(links)
    panel.select_region(links[0])
    assert panel._rows[0].region == links[0]
    panel.show_frame(touched(prepared.map, [8]))
    assert not bar.isVisible()


def test_contact_whose_force_is_not_controlled_has_an_open_mark(panel):
    frame = touched(leaf_map(), [10, 300])
    first, second = sorted(region.id for region in frame.regions)
    panel.show_frame(replace(frame, task=TaskReport(controlled=(second,))))
    rows = {row.region: row for row in panel._rows}
    assert ("○" in rows[first]._cells[0].text(), "○" in rows[second]._cells[0].text()) == (True, False)
    assert "Force not controlled" in rows[first].button.toolTip()
    assert "Force controlled" in rows[second].button.toolTip()
    panel.show_frame(frame)
    assert all("●" in rows[region]._cells[0].text() for region in (first, second)), "a controller without a task"
