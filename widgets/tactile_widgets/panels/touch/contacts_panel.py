"""The contacts panel: the contact regions now (where, how hard, how large, how certain), and how they are estimated.

A click on a row selects the region. Below the rows: force and centre with standard uncertainties, how well conditioned
the force estimate is, and the choice of force estimator and of the pressure from which a taxel counts as touched.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QGridLayout, QInputDialog, QLabel, QPushButton, QScrollBar, QVBoxLayout, QWidget

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.force_estimation.estimate import EstimateRefusal, EstimatorName, ForceEstimate
from tactile_maps.contacts.force_estimation.estimation import FORCE_ESTIMATORS
from tactile_maps.contacts.pipeline import THRESHOLDS as LIMITS
from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.scene.effects import EFFECTS, Effects
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.tactile.mechanics.contact_notes import contact_note_text
from tactile_maps.tactile.sensors.sensor_effects import ALIVE
from tactile_widgets.common.panel import FlatComboBox, Panel, value_label
from tactile_widgets.document.taxel_selection import TaxelSelection, region_colour
from tactile_widgets.overlays.taxel_faults import TaxelFaults
from tactile_widgets.panels.touch.held_fingers import HeldFingers

_REFUSALS = {
    EstimateRefusal.RANK: "the effective rank is too low, because the cover is too deep or the noise too high",
    EstimateRefusal.NO_FORCE: "no force is measured",
    EstimateRefusal.WRENCH_RANK: "too few components of force and torque are known",
    EstimateRefusal.OFF_SKIN: "the line of the force misses the skin, as with several contacts or a twist",
    EstimateRefusal.PULL: "the estimated force would pull",
}


def estimate_text(estimate: ForceEstimate, units: ReadingUnits = ReadingUnits.CALIBRATED) -> str:
    """Like "Effective rank 12/14, residual 1.1 × noise", with condition, peak and mean below; or why it was refused."""
    told = f"Effective rank {estimate.effective_rank}/{estimate.unknowns}"
    condition = _format_number(estimate.condition)
    if estimate.refused is not None:
        return f"{told}, condition {condition}\nRefused: {_REFUSALS[estimate.refused]}"
    if not len(estimate.forces):  # there is no distribution to explain readings with
        return f"Wrench: {told[0].lower()}{told[1:]}\nResultant wrench only, no pressure distribution"
    mean = units.reading(estimate.mean)
    residual = _residual_text(estimate, units)
    return f"{told}, {residual}\nCondition {condition}, peak {1e-3 * estimate.peak:.1f} and mean {mean}"


def _residual_text(estimate: ForceEstimate, units: ReadingUnits) -> str:
    if estimate.noise > 0:
        return f"residual {_format_number(estimate.misfit)}\u202f×\u202fnoise"
    return f"residual {1e-3 * estimate.residual:.2g}\u202f{units.unit}"


def _format_number(value: float) -> str:
    if not math.isfinite(value):
        return "∞"
    return f"{value:.2g}" if value < 100 else f"{value:.0f}" if value < 1e4 else f"{value:.0e}"


ESTIMATORS: dict[EstimatorName, tuple[str, str]] = {
    "area-sum": (
        "Force: pressure × area",
        "Summed over the touched taxels and the ring around them. No extra cost; total force within a few percent.\n"
        "No distribution: below a cover, peaks are too low and too wide.",
    ),
    "local-nnls": (
        "Force: NNLS deconvolution",
        "Non-negative least squares on the region and its ring, with the cover's blur undone. 0.1 ms a contact.\n"
        "Resolves the distribution; noise may make the total some percent too large. Assumes the scene's taxel depth.",
    ),
    "tikhonov": (
        "Force: Tikhonov (discrepancy principle)",
        "Tikhonov regularisation; its weight makes the residual equal to the noise (discrepancy principle).\n"
        "0.1 ms a contact. Resolves the distribution; pressures at the edge may be negative.",
    ),
    "lumped": (
        "Force: force-torque sensor in the link",
        "Ideal force-torque sensor in each link, gravity compensated, without a skin.\n"
        "0.2 ms a link. Includes friction, but merges several contacts of a link into one, without a distribution.",
    ),
}
"""Words and tool tip of the built-in ones by name."""
ESTIMATOR_TIP = "Force estimator: how contact forces follow from the readings; controllers use the result"
THRESHOLD_TIP = (
    "Contact threshold: a taxel is in contact from this pressure on, and stays so down to half of it.\n"
    "Automatic is 1\u202fkPa (1 count of a skin that is not calibrated), or three standard deviations of the noise if\n"
    "that is more. After a tare each taxel of a real skin has its own noise, and thus its own threshold."
)
THRESHOLDS = (None, 500.0, 1000.0, 2000.0, 3000.0, 5000.0, 10000.0)
"""[Pa]; None is automatic."""
COUNT_THRESHOLDS = (None, 1e3, 3e3, 1e4, 3e4, 1e5, 3e5, 1e6, 3e6, 1e7)
"""The same where readings are counts, each shown as 1 kPa."""
SHEAR_NOTE = "Net shear is unobservable"
SHEAR_TIP = (
    "These taxels sense normal stress. A tangential force on the cover presses on one side of itself and pulls on the\n"
    "other: the normal stress below it sums to zero (Cerruti's solution has no mean). Any net shear could be added\n"
    "to a contact without changing the sum, so none is estimated. The true friction is only known to the simulation\n"
    "and to a force and torque sensor in the link."
)


def threshold_text(
    threshold: float | None,
    usual: float,
    units: ReadingUnits = ReadingUnits.CALIBRATED,
    *,
    measured: bool = False,
) -> str:
    """Like "Contact threshold 2 kPa".

    Args:
        threshold: The chosen one [Pa]; None for automatic.
        usual: Automatic threshold [Pa].
        units: Units of the readings.
        measured: Whether a real skin is shown, whose taxels may have higher automatic thresholds.
    """
    level = f"{_threshold_number(usual if threshold is None else threshold)}\u202f{units.unit}"
    if threshold is not None:
        return f"Contact threshold {level}"
    return f"Automatic threshold ≥ {level}" if measured else f"Contact threshold {level}, automatic"


def _threshold_number(pascals: float) -> str:
    return f"{1e-3 * pascals:.3g}" if pascals < 1e6 else f"{1e-3 * pascals:,.0f}"


def estimator_words(name: EstimatorName) -> tuple[str, str]:
    """Words and tool tip of an estimator; those of a plug-in are its own."""
    if name in ESTIMATORS:
        return ESTIMATORS[name]
    entry = FORCE_ESTIMATORS[name]
    return f"Force: {entry.title}", entry.tip


class EstimationControls(QWidget):
    """Two choices; it shows what is in force, and tells what a person wants."""

    reading_edited = Signal(ReadingSettings)
    """Contact settings entered by the user."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._settings = ReadingSettings()
        self._usual = ReadingSettings().threshold_for(SensorUncertainty())
        self._units = ReadingUnits.CALIBRATED
        self._measured = False
        self.estimator = self._choice("choice-estimator", ESTIMATOR_TIP)
        for name in FORCE_ESTIMATORS:
            words, tip = estimator_words(name)
            self.estimator.addItem(words, name)
            self.estimator.setItemData(self.estimator.count() - 1, tip, Qt.ItemDataRole.ToolTipRole)
        self.threshold = self._choice("choice-threshold", THRESHOLD_TIP)
        self.threshold.setToolTip(THRESHOLD_TIP)
        self._list_thresholds()
        self.estimator.activated.connect(self._on_estimator_chosen)
        self.threshold.activated.connect(self._on_threshold_chosen)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.estimator)
        column.addWidget(self.threshold)
        self.show_reading(self._settings)

    def show_reading(self, settings: ReadingSettings) -> None:
        """Show the settings in force."""
        self._settings = settings
        words, tip = estimator_words(settings.estimator)
        self.estimator.setCurrentIndex(self.estimator.findData(settings.estimator))
        self.estimator.say(words)
        self.estimator.setToolTip(f"{ESTIMATOR_TIP}.\n\n{tip}")
        for row, threshold in enumerate(self._thresholds):
            self.threshold.setItemText(row, self._threshold_text(threshold))
        known = settings.threshold in self._thresholds  # a scene may name any
        self.threshold.setCurrentIndex(self._thresholds.index(settings.threshold) if known else -1)
        self.threshold.say(self._threshold_text(settings.threshold))

    def show_effects(self, effects: Effects) -> None:
        """The noise in force says what automatic means."""
        self._usual = ReadingSettings().threshold_for(SensorUncertainty.of_sensor(effects.sensor))
        self.show_reading(self._settings)

    def set_units(self, units: ReadingUnits, *, measured: bool = False) -> None:
        """What readings may be called, and whether a real skin is shown; without a force there is no estimator."""
        self._units = units
        self._measured = measured
        self._list_thresholds()
        self.estimator.setVisible(units.force is not None)
        self.show_reading(self._settings)

    def _choice(self, name: str, tip: str) -> FlatComboBox:
        box = FlatComboBox(self)
        box.setObjectName(name)
        box.setAccessibleName(tip.split("\n")[0])
        return box

    def _on_estimator_chosen(self, row: int) -> None:
        self._edit(replace(self._settings, estimator=self.estimator.itemData(row)))

    @property
    def _thresholds(self) -> tuple[float | None, ...]:
        return COUNT_THRESHOLDS if self._units is ReadingUnits.COUNTS else THRESHOLDS

    def _list_thresholds(self) -> None:
        self.threshold.clear()
        for threshold in self._thresholds:
            self.threshold.addItem("", threshold)
        self.threshold.addItem("Other contact threshold…")

    def _threshold_text(self, threshold: float | None) -> str:
        return threshold_text(threshold, self._usual, self._units, measured=self._measured)

    def _on_threshold_chosen(self, row: int) -> None:
        if row == len(self._thresholds):
            self._ask_threshold()
        else:
            self._edit(replace(self._settings, threshold=self._thresholds[row]))

    def _ask_threshold(self) -> None:
        box = QInputDialog(self)
        box.setObjectName("ask-threshold")
        box.setWindowTitle("Contact threshold")
        box.setLabelText(f"A taxel is in contact at or above this value ({self._units.unit}):")
        box.setInputMode(QInputDialog.InputMode.DoubleInput)
        box.setDoubleDecimals(3)
        box.setDoubleRange(*(1e-3 * limit for limit in LIMITS))
        box.setDoubleValue(1e-3 * (self._settings.threshold or self._usual))
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.doubleValueSelected.connect(self._on_threshold_entered)
        box.finished.connect(self._on_threshold_asked)
        box.open()

    def _on_threshold_entered(self, value: float) -> None:
        self._edit(replace(self._settings, threshold=1e3 * value))

    def _on_threshold_asked(self) -> None:
        """Show the current threshold again, also where the question was cancelled."""
        self.show_reading(self._settings)

    def _edit(self, settings: ReadingSettings) -> None:
        if settings != self._settings:
            self.show_reading(settings)
            self.reading_edited.emit(settings)


_ROWS = 3
"""More than that is rare; the line above counts and sums all of them."""
_FORCE_TIP = "Normal force from the selected estimator; controllers use the same value."
_ESTIMATE_TIP = (
    "Of the same contact: effective rank (how many of the taxel forces the readings determine above their noise),\n"
    "condition number, and residual. A residual near the noise is as good as can be; far above it, the model of the\n"
    "cover is wrong. Where the rank is below half of the unknowns, no distribution is given, and the contact keeps\n"
    "the sum of pressure times area."
)
_FACTS_TIP = (
    "Of the selected contact, or else the strongest: force and place with their standard uncertainties\n"
    "(effects of the sensor and the taxels' spacing), mean pressure, and the size of the ellipse it covers.\n"
    "A saturated taxel gives a lower bound of the force only."
)
_FACT_LINES = 3
"""As many as a region's facts may take; the rows below never jump."""
_ESTIMATE_LINES = 4
"""As high as the longest estimate; the rows below never jump."""
_ROW_STYLE = """
    QPushButton { border: 0; border-radius: 4px; padding: 0; margin: -2px -6px; background: transparent; }
    QPushButton:enabled:hover { background: rgba(128, 140, 152, 40); }
    QPushButton:checked { background: rgba(34, 184, 207, 70); }
    QPushButton:focus { border: 1px solid #22b8cf; }
"""


_ROW_TIP = "Highlight this contact's trace; click again to clear"
_CONTROLLED_TIPS = {
    True: "Force controlled",
    False: "Force not controlled: it is below the force goal, or the controller panel shows the reason",
}
_NAME_PX = 84
"""What the column leaves for a link's name before it has been laid out."""


class ContactRow:
    """One row of the panel's grid: a button under the facts about one region.

    Args:
        row: Number in the grid.
        grid: Where to stand.
        parent: Qt parent.
    """

    def __init__(self, row: int, grid: QGridLayout, parent: QWidget) -> None:
        self.region: int | None = None
        self.button = QPushButton(parent)
        self.button.setObjectName(f"contact-{row}")
        self.button.setAccessibleName("No contact")
        self.button.setCheckable(True)
        self.button.setStyleSheet(_ROW_STYLE)
        grid.addWidget(self.button, row, 0, 1, 5)
        self._mark = value_label("", parent)
        self._cells = [value_label("", parent, right=column > 0) for column in range(4)]
        for column, cell in enumerate((self._mark, *self._cells)):
            cell.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
            cell.setFixedHeight(cell.fontMetrics().height() + 2)
            grid.addWidget(cell, row, column)
        self.button.setFixedHeight(self._mark.height())
        for cell in self._cells:
            cell.setMinimumWidth(40)

    def show(
        self,
        region: ContactRegion | None,
        *,
        selected: bool,
        units: ReadingUnits,
        estimate: ForceEstimate | None = None,
        controlled: bool | None = None,
    ) -> None:
        """Show what is known of a region; None empties the row.

        Args:
            region: To show.
            selected: Whether the row is highlighted.
            units: Units of the readings.
            estimate: Of its force, for the tool tip.
            controlled: Whether its force is controlled; None where the controller does no task.
        """
        texts = ["", "", "", ""]
        ink = ""
        if region is not None:
            metrics = self._cells[0].fontMetrics()
            cell = self._cells[0]
            room = cell.width() if cell.isVisible() else _NAME_PX  # it stretches, so its text does not decide its width
            name = metrics.elidedText(region.link, Qt.TextElideMode.ElideMiddle, room)
            force = "" if units.force is None else f"{region.force:.2f}"
            texts = [name, force, f"{1e-3 * region.peak:.1f}", f"{1e6 * region.area:.0f}"]
            mark = "○" if controlled is False else "●"
            ink = f'<span style="color:{region_colour(region.id)}">{mark}</span>'
        self.region = None if region is None else region.id
        self.button.setEnabled(region is not None)
        self.button.setChecked(selected)
        facts = [estimate_text(estimate, units)] if estimate else []
        if controlled is not None:
            facts.append(_CONTROLLED_TIPS[controlled])
        self.button.setToolTip("\n\n".join([*facts, _ROW_TIP]))
        told = "" if region is None else units.contact_words(region.force, region.peak, 2, space=" ")
        self.button.setAccessibleName("No contact" if region is None else f"Contact on {region.link}, {told}")
        for cell, text in zip((self._mark, *self._cells), (ink, *texts), strict=True):
            if cell.text() != text:
                cell.setText(text)


def region_summary(region: ContactRegion, among: Sequence[ContactRegion], units: ReadingUnits) -> str:
    """What is known of a region, in two lines; a third names the one among ``among`` that it touches."""
    long, short = 2e3 * np.linalg.norm(region.link_axes, axis=1)
    size = f"{long:.0f} × {short:.0f}\u202fmm" if long > 0 else "shape not resolved"
    error = units.force_words(region.force_error, 2)
    bound = "At least " if region.force_parts.get("saturation") else ""
    force = "Force unknown" if error is None else f"{bound}{region.force:.2f} ± {error}"
    if error is not None and math.isinf(region.force_error):
        force = f"{units.force_words(region.force, 2)} of unknown accuracy"
    lines = [
        f"{force}, centre ± {1e3 * region.place_error:.1f}\u202fmm",
        f"Mean {units.reading(region.mean)}, {size}",
    ]
    lines += [f"Touches {other.link.replace('_', ' ')}" for other in among if other.id == region.partner]
    return "\n".join(lines)


_PARTS = {
    "ring": "force outside the ring",
    "contact_model": "contact model",
    "estimator": "force estimator",
    "wrench": "force-torque sensor",
}
_SHOWN_PARTS = 4


def uncertainty_text(region: ContactRegion, units: ReadingUnits) -> str:
    """Like "Uncertainty mostly from hysteresis: hysteresis 0.35 N, noise 0.10 N", or "" where no part is known."""
    parts = sorted(region.force_parts.items(), key=lambda part: -part[1])
    if units.force is None or not parts or not parts[0][1] > 0:
        return ""
    titles = {name: EFFECTS[name].title.lower() if name in EFFECTS else _PARTS.get(name, name) for name, _ in parts}
    listed = [
        f"{titles[name]} {units.force_words(part, 2) if math.isfinite(part) else '∞'}"
        for name, part in parts[:_SHOWN_PARTS]
        if part > 0
    ]
    return (
        f"Uncertainty of the force mostly from {titles[parts[0][0]]}:\n{', '.join(listed)}\n{_interval(region, units)}"
    )


def _interval(region: ContactRegion, units: ReadingUnits) -> str:
    low, high = region.force_interval
    if math.isinf(high):
        if low > 0:
            return f"With a probability of 95 % at least {units.force_words(low, 2)}"
        if not math.isinf(region.force_parts.get("contact_model", 0.0)):
            return "No upper limit"
        return "No upper limit: depths are not pressures, and the force also depends on the size and place of the body"
    return f"With a probability of 95 % between {low:.2f} and {units.force_words(high, 2)}"


def faults_text(faults: TaxelFaults) -> str:
    """Like "4 broken taxels: 3 estimated from their neighbours, 1 blind (0.8 cm²)"; empty where none is broken."""
    count = int(np.count_nonzero(faults.broken != ALIVE))
    if not count:
        return ""
    words = f"{count} broken {'taxel' if count == 1 else 'taxels'}"
    if not faults.estimated:
        return f"{words}, used as read"
    blind = sum(len(area.taxels) for area in faults.blind)
    parts = [f"{count - blind} estimated from neighbours"] if count > blind else []
    if blind:
        parts.append(f"{blind} blind ({1e4 * sum(area.area for area in faults.blind):.3g}\u202fcm²)")
    return f"{words}: {', '.join(parts)}"


_NAMED_AREAS = 6


def faults_tip(faults: TaxelFaults) -> str:
    """Return the blind areas by name, and what is done with broken taxels."""
    texts = [contact_note_text(area.note) for area in faults.blind[:_NAMED_AREAS]]
    texts = [f"{text[0].upper()}{text[1:]}." for text in texts]
    more = len(faults.blind) - _NAMED_AREAS
    if more > 0:
        texts.append(f"{more} more blind {'area' if more == 1 else 'areas'}.")
    return "\n".join([*texts, _FAULTS_TIP if faults.estimated else _AS_READ_TIP])


_FAULTS_TIP = (
    "For contacts, a broken taxel has the mean pressure of its working neighbours. A taxel with fewer than two\n"
    "working neighbours is blind: contacts on it are not reported, or with too little force."
)
_AS_READ_TIP = "The scene has broken taxels used as they are read."


class ContactsPanel(Panel):
    """A few rows that never jump: fixed in number, a scroll bar beside them; the older region above the younger."""

    region_selected = Signal(object)
    """The row of a region was clicked: its id; None if it was selected already."""
    reading_edited = Signal(ReadingSettings)
    """Contact settings entered by the user."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Contacts", "contacts-panel", parent)
        self._summary: QLabel = self.caption()
        self._summary.setObjectName("contacts-summary")
        self._selected: int | None = None
        self._sought = False
        self._estimated = False
        self._regions: tuple[ContactRegion, ...] = ()
        self._estimates: Mapping[int, ForceEstimate] = {}
        self._controlled: tuple[int, ...] | None = None
        grid = self.grid()
        grid.setHorizontalSpacing(8)
        self._units = ReadingUnits.CALIBRATED
        self._measured = False
        self._heads = [value_label("", self, right=column > 0) for column in range(4)]
        for column, head in enumerate(self._heads, start=1):
            head.setProperty("role", "caption")
            grid.addWidget(head, 0, column)
        self._rows = [ContactRow(row + 1, grid, self) for row in range(_ROWS)]
        for row in self._rows:
            row.button.clicked.connect(self._on_row_clicked)
        grid.setColumnStretch(1, 1)
        self.scroll_bar = QScrollBar(Qt.Orientation.Vertical, self)
        self.scroll_bar.setObjectName("contacts-scroll")
        self.scroll_bar.setAccessibleName("Contacts shown")
        self.scroll_bar.setPageStep(_ROWS)
        keeps = self.scroll_bar.sizePolicy()
        keeps.setRetainSizeWhenHidden(True)  # or the columns would jump with the fourth contact
        self.scroll_bar.setSizePolicy(keeps)
        self.scroll_bar.valueChanged.connect(self._on_scrolled)
        self.scroll_bar.hide()
        grid.addWidget(self.scroll_bar, 1, 5, _ROWS, 1)
        self._facts: QLabel = self.caption()
        self._facts.setObjectName("contacts-facts")
        self._facts.setToolTip(_FACTS_TIP)
        self._facts.setFixedHeight(_FACT_LINES * self._facts.fontMetrics().lineSpacing() + 2)
        self._facts.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._told: QLabel = self.caption()
        self._told.setObjectName("contacts-estimate")
        self._told.setToolTip(_ESTIMATE_TIP)
        self._told.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.fingers = HeldFingers(self)
        self.column.addWidget(self.fingers)
        self.reading = EstimationControls(self)
        self.reading.reading_edited.connect(self._on_reading_edited)
        self.column.addWidget(self.reading)
        self._faults: QLabel = self.caption()
        self._faults.setObjectName("contacts-faults")
        self._faults.hide()
        shear = self.caption(SHEAR_NOTE)
        shear.setObjectName("contacts-shear")
        shear.setToolTip(SHEAR_TIP)
        self.show_reading(ReadingSettings())
        self._use_units(self._units)
        self.clear()

    def show_reading(self, settings: ReadingSettings) -> None:
        """Show how contacts are read; what that says of its own answers has its place, or takes none."""
        self.reading.show_reading(settings)
        self._estimated = settings.estimator != "area-sum"
        self._show_told()
        self._told.setFixedHeight(_ESTIMATE_LINES * self._told.fontMetrics().lineSpacing())

    def show_effects(self, effects: Effects) -> None:
        """The noise in force is part of what the usual threshold means."""
        self.reading.show_effects(effects)

    def show_faults(self, faults: TaxelFaults) -> None:
        """Name broken taxels and blind areas; nothing where there are none."""
        text = faults_text(faults)
        self._faults.setText(text)
        self._faults.setToolTip(faults_tip(faults))
        self._faults.setHidden(not text)

    def set_editable(self, *, editable: bool) -> None:
        """Let a person change how contacts are read, or not; they may be selected anyhow."""
        self.reading.setEnabled(editable)
        self.fingers.setEnabled(editable)

    def follow(self, selection: TaxelSelection) -> None:
        """Select there, and highlight what is selected there, from now on."""
        self.region_selected.connect(selection.select_region)
        selection.region_changed.connect(self.select_region)
        self.select_region(selection.region)

    def clear(self) -> None:
        """Nothing is touched."""
        self._regions = ()
        self._estimates = {}
        self._controlled = None
        self._summary.setText("No contact." if self._measured else "No contact. Press the skin in a view.")
        self._fill()

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Another scene: what was shown is over."""
        self.fingers.show_skin(prepared.skin)
        self.clear()

    def show_frame(self, frame: Frame) -> None:
        """The strongest regions of a frame, and the selected one."""
        self._regions = frame.regions
        self._estimates = frame.estimates
        self._controlled = None if frame.task is None else frame.task.controlled
        self.fingers.show_frame(frame)
        measured = frame.measured is not None
        if (frame.units, measured) != (self._units, self._measured):
            self._use_units(frame.units, measured=measured)
        if not frame.regions:
            self.clear()
            return
        noun = "contact" if len(frame.regions) == 1 else "contacts"
        force = sum(region.force for region in frame.regions)
        told = self._units.force_words(force)
        words = "force unknown: not calibrated" if told is None else f"{told} in all"
        self._summary.setText(f"{len(frame.regions)} {noun}, {words}")
        self._fill()

    def _use_units(self, units: ReadingUnits, *, measured: bool = False) -> None:
        self._units = units
        self._measured = measured
        for head, text in zip(self._heads, ("On", units.force or "", units.unit, "mm²"), strict=True):
            head.setText(text)
        self._heads[1].setToolTip("" if units.force is None else _FORCE_TIP)
        self.reading.set_units(units, measured=measured)
        self.fingers.setHidden(measured)  # nothing is simulated that they could press
        self._show_told()

    def _show_told(self) -> None:
        """What the force estimator says of its own answers, where it has any and a force may be claimed."""
        self._told.setVisible(self._estimated and self._units.force is not None)

    def select_region(self, region: int | None) -> None:
        """Highlight the row of the region with this id, and bring it into sight; None for none."""
        self._selected = region
        self._sought = region is not None
        self._fill()

    @property
    def _ordered(self) -> list[ContactRegion]:
        """The older region above the younger."""
        return sorted(self._regions, key=lambda region: region.id)

    def _on_scrolled(self, _first: int) -> None:
        self._fill()

    def _fill(self) -> None:
        most = max(len(self._regions) - _ROWS, 0)
        self.scroll_bar.blockSignals(True)  # what it would tell is done here
        self.scroll_bar.setRange(0, most)
        place = next((k for k, one in enumerate(self._ordered) if one.id == self._selected), None)
        if self._sought and place is not None:  # once: afterwards a person may scroll it out of sight
            self._sought = False
            self.scroll_bar.setValue(min(max(self.scroll_bar.value(), place - _ROWS + 1), place))
        self.scroll_bar.blockSignals(False)
        self.scroll_bar.setVisible(most > 0)
        first = sorted(self._regions, key=lambda region: region.id != self._selected)
        shown = self._ordered[self.scroll_bar.value() :]
        for number, row in enumerate(self._rows):
            region = shown[number] if number < len(shown) else None
            known = None if region is None else self._estimates.get(region.id)
            controlled = None
            if region is not None and self._controlled is not None:
                controlled = region.id in self._controlled
            row.show(
                region,
                selected=region is not None and region.id == self._selected,
                units=self._units,
                estimate=known,
                controlled=controlled,
            )
        self._facts.setText(region_summary(first[0], self._regions, self._units) if first else "")
        parts = uncertainty_text(first[0], self._units) if first else ""
        self._facts.setToolTip(f"{parts}\n\n{_FACTS_TIP}" if parts else _FACTS_TIP)
        told = self._estimates.get(first[0].id) if first else None
        self._told.setEnabled(told is not None and told.refused is None)
        self._told.setText(estimate_text(told, self._units) if told is not None else "")

    def _on_reading_edited(self, settings: ReadingSettings) -> None:
        self.show_reading(settings)
        self.reading_edited.emit(settings)

    def _on_row_clicked(self) -> None:
        row = next(row for row in self._rows if row.button is self.sender())
        again = row.region == self._selected
        self._fill()  # the button has turned by itself; only the selection decides
        self.region_selected.emit(None if again else row.region)
