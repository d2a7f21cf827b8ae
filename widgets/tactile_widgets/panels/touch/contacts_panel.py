"""The contacts panel: link, force, pressure and area of the current contact regions, and how they are estimated.

A click on a row selects the region. Below the rows are force and centre with standard uncertainties, the conditioning
of the force estimate, and the choice of the force estimator and of the pressure from which a taxel is in contact.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QGridLayout, QInputDialog, QPushButton, QScrollBar, QSizePolicy, QWidget

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.contact_shear import ContactShear, Slip
from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.force_estimation.estimate import EstimateRefusal, EstimatorName, ForceEstimate
from tactile_maps.contacts.force_estimation.estimation import FORCE_ESTIMATORS
from tactile_maps.contacts.pipeline import THRESHOLDS as LIMITS
from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.core.reading_units import THIN, ReadingUnits
from tactile_maps.scene.effects import EFFECTS, Effects
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.tactile.mechanics.contact_notes import (
    ContactNote,
    ContactNoteKind,
    contact_note_text,
    lacking_shares,
)
from tactile_maps.tactile.sensors.sensor_effects import ALIVE
from tactile_widgets.common.make import (
    DELETED_ON_CLOSE,
    ElidedLabel,
    add_items,
    column_layout,
    make,
    select_data,
    show_text,
    value_label,
)
from tactile_widgets.common.panel import FlatComboBox, Panel
from tactile_widgets.common.sentence import capitalized
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
    """Return a text like "Effective rank 12/14, residual 1.1 × noise", with condition, peak and mean below.

    The text of a refused estimate contains the reason.
    """
    rank = f"effective rank {estimate.effective_rank}/{estimate.unknowns}"
    condition = _format_number(estimate.condition)
    if estimate.refused is not None:
        return f"{rank.capitalize()}, condition {condition}\nRejected: {_REFUSALS[estimate.refused]}"
    if not len(estimate.forces):  # no distribution that could explain the readings
        return f"Wrench: {rank}\nResultant wrench only, no pressure distribution"
    mean = units.reading(estimate.mean)
    residual = _residual_text(estimate, units)
    return f"{rank.capitalize()}, {residual}\nCondition {condition}, peak {1e-3 * estimate.peak:.1f} and mean {mean}"


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
"""Text and tool tip of the built-in estimators by name."""
ESTIMATOR_TIP = "Force estimator: how contact forces follow from the readings; controllers use the result"
THRESHOLD_TIP = (
    "Contact threshold: a taxel is in contact from this pressure on, and stays in contact down to half of it.\n"
    "Automatic is 1\u202fkPa (1 count of a skin that is not calibrated), or three standard deviations of the noise if\n"
    "that is more. After a tare each taxel of a real skin has its own noise, and thus its own threshold."
)
THRESHOLDS = (None, 500.0, 1000.0, 2000.0, 3000.0, 5000.0, 10000.0)
"""Offered thresholds [Pa]; None is automatic."""
COUNT_THRESHOLDS = (None, 1e3, 3e3, 1e4, 3e4, 1e5, 3e5, 1e6, 3e6, 1e7)
"""Offered thresholds of readings in counts, of which each is shown as 1 kPa."""
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
    """Return a text like "Contact threshold 2 kPa".

    Args:
        threshold: Chosen threshold [Pa]; None for automatic.
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
    """Return text and tool tip of an estimator, which may be a plug-in."""
    if name in ESTIMATORS:
        return ESTIMATORS[name]
    entry = FORCE_ESTIMATORS[name]
    return f"Force: {entry.title}", entry.tip


class EstimationControls(QWidget):
    """Choice of the force estimator and of the contact threshold."""

    reading_edited = Signal(ReadingSettings)
    """Contact settings entered by the user."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._settings = ReadingSettings()
        self._errors = SensorUncertainty()
        self._units = ReadingUnits.CALIBRATED
        self._measured = False
        self.estimator = make(
            FlatComboBox,
            self,
            objectName="choice-estimator",
            accessibleName=ESTIMATOR_TIP,
            activated=self._on_estimator_chosen,
        )
        texts = ((name, *estimator_words(name)) for name in FORCE_ESTIMATORS)
        add_items(self.estimator, ((words, name, tip) for name, words, tip in texts))
        self.threshold = make(
            FlatComboBox,
            self,
            objectName="choice-threshold",
            accessibleName=THRESHOLD_TIP.split("\n")[0],
            toolTip=THRESHOLD_TIP,
            activated=self._on_threshold_chosen,
        )
        self._list_thresholds()
        column_layout(self.estimator, self.threshold, parent=self, spacing=4)
        self.show_reading(self._settings)

    def show_reading(self, settings: ReadingSettings) -> None:
        """Show the current settings."""
        self._settings = settings
        words, tip = estimator_words(settings.estimator)
        select_data(self.estimator, settings.estimator)
        self.estimator.say(words)
        self.estimator.setToolTip(f"{ESTIMATOR_TIP}.\n\n{tip}")
        for row, threshold in enumerate(self._thresholds):
            self.threshold.setItemText(row, self._threshold_text(threshold))
        known = settings.threshold in self._thresholds  # a scene may name any
        self.threshold.setCurrentIndex(self._thresholds.index(settings.threshold) if known else -1)
        self.threshold.say(self._threshold_text(settings.threshold))

    def show_effects(self, effects: Effects) -> None:
        """Update the automatic threshold, which depends on the noise of the sensor."""
        self._errors = SensorUncertainty.of_sensor(effects.sensor)
        self.show_reading(self._settings)

    def set_units(self, units: ReadingUnits, *, measured: bool = False) -> None:
        """Set the units of readings, and whether a real skin is connected; without a force there is no estimator."""
        self._units = units
        self._measured = measured
        self._list_thresholds()
        self.estimator.setVisible(units.force is not None)
        self.show_reading(self._settings)

    def _on_estimator_chosen(self, row: int) -> None:
        self._edit(replace(self._settings, estimator=self.estimator.itemData(row)))

    @property
    def _usual(self) -> float:
        """Automatic threshold [Pa]."""
        return replace(self._settings, threshold=None).threshold_for(self._errors)

    @property
    def _thresholds(self) -> tuple[float | None, ...]:
        return COUNT_THRESHOLDS if self._units is ReadingUnits.COUNTS else THRESHOLDS

    def _list_thresholds(self) -> None:
        self.threshold.clear()
        add_items(self.threshold, (("", threshold, "") for threshold in self._thresholds))
        self.threshold.addItem("Other contact threshold…")

    def _threshold_text(self, threshold: float | None) -> str:
        return threshold_text(threshold, self._usual, self._units, measured=self._measured)

    def _on_threshold_chosen(self, row: int) -> None:
        if row == len(self._thresholds):
            self._ask_threshold()
        else:
            self._edit(replace(self._settings, threshold=self._thresholds[row]))

    def _ask_threshold(self) -> None:
        box = make(
            QInputDialog,
            self,
            objectName="ask-threshold",
            windowTitle="Contact threshold",
            labelText=f"A taxel is in contact at or above this value ({self._units.unit}):",
            inputMode=QInputDialog.InputMode.DoubleInput,
            doubleDecimals=3,
            doubleMinimum=1e-3 * LIMITS[0],
            doubleMaximum=1e-3 * LIMITS[1],
            doubleValue=1e-3 * (self._settings.threshold or self._usual),
            attribute=DELETED_ON_CLOSE,
            doubleValueSelected=self._on_threshold_entered,
            finished=self._on_threshold_asked,
        )
        box.open()

    def _on_threshold_entered(self, value: float) -> None:
        self._edit(replace(self._settings, threshold=1e3 * value))

    def _on_threshold_asked(self) -> None:
        """Show the current threshold again, also after the dialog was cancelled."""
        self.show_reading(self._settings)

    def _edit(self, settings: ReadingSettings) -> None:
        if settings != self._settings:
            self.show_reading(settings)
            self.reading_edited.emit(settings)


_ROWS = 3
"""Number of rows; more contacts are rare, and the line above counts and sums all of them."""
_FORCE_TIP = "Normal force from the selected estimator; controllers use the same value."
_ESTIMATE_TIP = (
    "The same contact: effective rank (how many of the taxel forces the readings determine above their noise),\n"
    "condition number, and residual. A residual near the noise is optimal; far above it, the model of the cover is\n"
    "wrong. If the rank is below half of the unknowns, no distribution is given, and the contact keeps\n"
    "the sum of pressure times area."
)
_FACTS_TIP = (
    "The selected contact, or the strongest one: force and place with their standard uncertainties\n"
    "(effects of the sensor and the taxels' spacing), mean pressure, and the size of the ellipse it covers.\n"
    "A saturated taxel gives a lower bound of the force only."
)
_FACT_LINES = 3
_ESTIMATE_LINES = 4
"""Reserved lines of text, for the longest facts and estimates: the rows below never move."""
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
_NAME_PX = 64
"""Least width of the name of a link [px]."""


_COLUMNS = 5
_BEGINS = "◐"
_HEADS = {
    False: (("", ""), ("mm²", "")),
    True: (
        ("shear", "Force along the skin [N]"),
        (
            "friction",
            "Friction in use: force along the skin over friction coefficient times normal force.\n"
            f"{_BEGINS} the contact begins to slip at its border; it slides from 95 % on",
        ),
    ),
}
"""Texts and tool tips of the heads of the last columns, without and with shear; the first is the unit of pressure."""
_SLIP_WORDS = {Slip.STICKING: "sticking", Slip.INCIPIENT: "incipient slip", Slip.SLIDING: "sliding"}


def _last_cells(region: ContactRegion, *, shear: bool) -> tuple[str, str]:
    """Peak pressure and area, or shear and friction in use, for which there is no room next to them."""
    if not shear:
        return f"{1e-3 * region.peak:.1f}", f"{1e6 * region.area:.0f}"
    if region.shear is None:
        return "", ""
    return f"{np.linalg.norm(region.shear.force):.2f}", friction_text(region.shear)


def friction_text(shear: ContactShear) -> str:
    """Return a text like "86 %", with a mark while slip begins, or "slides"."""
    if shear.slip is Slip.SLIDING:
        return "slides"
    usage = f"{100 * shear.usage:.0f}{THIN}%"
    return f"{_BEGINS}{THIN}{usage}" if shear.slip is Slip.INCIPIENT else usage


def shear_text(shear: ContactShear) -> str:
    """Return a text like "Shear 4.64 ± 0.10 N, 86 ± 2 % of the friction: incipient slip", with details below."""
    source = "measured while sliding" if shear.estimated else "given"
    return (
        f"Shear {np.linalg.norm(shear.force):.2f} ± {shear.force_error:.2f}{THIN}N, "
        f"{100 * shear.usage:.0f} ± {100 * shear.usage_error:.0f}{THIN}% of the friction: {_SLIP_WORDS[shear.slip]}\n"
        f"Friction coefficient {shear.friction:.2f} ({source}), {100 * shear.stuck:.0f}{THIN}% of the limit sticks\n"
        f"Torque about the normal {1e3 * shear.torque:.1f} ± {1e3 * shear.torque_error:.1f}{THIN}N{THIN}mm"
    )


class ContactRow:
    """A row of the panel's grid: a button behind the facts about one region.

    Args:
        row: Row of the grid.
        grid: Grid of the panel.
        parent: Qt parent.
    """

    def __init__(self, row: int, grid: QGridLayout, parent: QWidget) -> None:
        self.region: int | None = None
        self.button = make(
            QPushButton,
            parent,
            objectName=f"contact-{row}",
            accessibleName="No contact",
            checkable=True,
            styleSheet=_ROW_STYLE,
        )
        self._link = ElidedLabel(f"contact-link-{row}", parent, elided=Qt.TextElideMode.ElideMiddle)
        numbers = [value_label("", parent, right=True) for _ in range(2, _COLUMNS)]
        self._cells = [value_label("", parent), self._link, *numbers]
        for place, cell in enumerate(self._cells):
            cell.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
            cell.setFixedHeight(cell.fontMetrics().height() + 2)
            grid.addWidget(cell, row, place)
        self.button.setFixedHeight(self._cells[0].height())
        self._cells[0].setMinimumWidth(self._cells[0].fontMetrics().horizontalAdvance("●"))
        for cell in self._cells[2:]:
            cell.setMinimumWidth(40)
        self._link.setMinimumWidth(_NAME_PX)  # it takes the room that is left, whatever its text
        self._link.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        grid.addWidget(self.button, row, 0, 1, _COLUMNS)
        self.show_shear(shown=False)

    def show_shear(self, *, shown: bool) -> None:
        """Show shear instead of pressure and area, which are then in the tool tip."""
        self._shear = shown
        last = self._cells[-1]
        longest = last.fontMetrics().horizontalAdvance(f"{_BEGINS}{THIN}100{THIN}%")
        last.setMinimumWidth(longest if shown else 40)

    def show(
        self,
        region: ContactRegion | None,
        *,
        selected: bool,
        units: ReadingUnits,
        estimate: ForceEstimate | None,
        controlled: bool | None,
    ) -> None:
        """Show the facts about a region.

        Args:
            region: The region; None empties the row.
            selected: Whether the row is highlighted.
            units: Units of the readings.
            estimate: Estimate of the force, for the tool tip.
            controlled: Whether the force is controlled; None if the controller has no task.
        """
        texts = [""] * _COLUMNS
        name = "No contact"
        if region is not None:
            mark = "○" if controlled is False else "●"
            texts = [
                f'<span style="color:{region_colour(region.id)}">{mark}</span>',
                region.link,
                "" if units.force is None else f"{region.force:.2f}",
                *_last_cells(region, shear=self._shear),
            ]
            name = f"Contact on {region.link}, {units.contact_words(region.force, region.peak, 2, space=' ')}"
        self.region = None if region is None else region.id
        self.button.setEnabled(region is not None)
        self.button.setChecked(selected)
        facts = [estimate_text(estimate, units)] if estimate else []
        if region is not None and region.shear is not None:
            size = f"Peak {units.reading(region.peak)}, area {1e6 * region.area:.0f}{THIN}mm²"
            facts += [shear_text(region.shear), size]
        if controlled is not None:
            facts.append(_CONTROLLED_TIPS[controlled])
        self.button.setToolTip("\n\n".join([*facts, _ROW_TIP]))
        self.button.setAccessibleName(name)
        for cell, text in zip(self._cells, texts, strict=True):
            if cell.text() != text:
                cell.setText(text)


def region_summary(
    region: ContactRegion, among: Sequence[ContactRegion], units: ReadingUnits, lacking: Mapping[str, float]
) -> str:
    """Return the facts about a region in two lines.

    A third line states the share of the force on its link that contacts lack (``lacking``, by link), and the region in
    ``among`` that it touches.
    """
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
    more = [lacking_text(lacking[region.link])] if region.link in lacking and error is not None else []
    more += [f"touches {other.link.replace('_', ' ')}" for other in among if other.id == region.partner]
    return "\n".join(filter(None, (*lines, capitalized("; ".join(more)))))


def lacking_text(share: float) -> str:
    """Return a text like "lacks 38 % of the force: below the threshold"."""
    return f"lacks {100 * share:.0f}{THIN}% of the force: below the threshold"


def no_contact_text(notes: Sequence[ContactNote]) -> str:
    """Return the summary without contacts: a force below the threshold, or how to make a contact."""
    for note in notes:
        if note.kind is ContactNoteKind.BELOW_THRESHOLD and note.force is not None:
            link = note.bodies[-1].replace("_", " ")
            return f"No contact: {note.force:.3g}{THIN}N on {link} is below the threshold."
    return "No contact. Press the skin in a view."


_PARTS = {
    "ring": "force outside the ring",
    "contact_model": "contact model",
    "estimator": "force estimator",
    "wrench": "force-torque sensor",
}
_SHOWN_PARTS = 4


def uncertainty_text(region: ContactRegion, units: ReadingUnits) -> str:
    """Return a text like "Uncertainty mostly from hysteresis: hysteresis 0.35 N, noise 0.10 N".

    The text is empty if no part is known.
    """
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
    """Return a text like "4 broken taxels: 3 estimated from neighbours, 1 blind (0.8 cm²)"; empty if none is broken."""
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
    """Return the names of the blind areas, and how broken taxels are treated."""
    texts = [f"{capitalized(contact_note_text(area.note))}." for area in faults.blind[:_NAMED_AREAS]]
    more = len(faults.blind) - _NAMED_AREAS
    if more > 0:
        texts.append(f"{more} more blind {'area' if more == 1 else 'areas'}.")
    return "\n".join([*texts, _FAULTS_TIP if faults.estimated else _AS_READ_TIP])


_FAULTS_TIP = (
    "For contacts, a broken taxel has the mean pressure of its working neighbours. A taxel with fewer than two\n"
    "working neighbours is blind: contacts on it are not reported, or with too little force."
)
_AS_READ_TIP = "The scene uses the readings of broken taxels unchanged."


class ContactsPanel(Panel):
    """Contact regions in a fixed number of rows with a scroll bar, the oldest region first."""

    region_selected = Signal(object)
    """Id of the region whose row was clicked; None if it was selected already."""
    reading_edited = Signal(ReadingSettings)
    """Contact settings entered by the user."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Contacts", "contacts-panel", parent)
        self._summary = self.caption(name="contacts-summary")
        self._selected: int | None = None
        self._reveal = False
        self._has_estimate = False
        self._regions: tuple[ContactRegion, ...] = ()
        self._estimates: Mapping[int, ForceEstimate] = {}
        self._controlled: tuple[int, ...] | None = None
        self._notes: tuple[ContactNote, ...] = ()
        self._units = ReadingUnits.CALIBRATED
        self._measured = False
        grid = self.grid()
        grid.setHorizontalSpacing(8)
        grid.setColumnStretch(1, 1)
        self._heads = [value_label("", self, right=column > 0, role="caption") for column in range(_COLUMNS - 1)]
        for place, head in enumerate(self._heads, start=1):
            grid.addWidget(head, 0, place)
        self._rows = [ContactRow(row + 1, grid, self) for row in range(_ROWS)]
        for row in self._rows:
            row.button.clicked.connect(self._on_row_clicked)
        self.scroll_bar = make(
            QScrollBar,
            Qt.Orientation.Vertical,
            self,
            objectName="contacts-scroll",
            accessibleName="Contacts shown",
            pageStep=_ROWS,
            valueChanged=self._fill,
        )
        policy = self.scroll_bar.sizePolicy()
        policy.setRetainSizeWhenHidden(True)  # or the columns would move with the fourth contact
        self.scroll_bar.setSizePolicy(policy)
        self.scroll_bar.hide()
        grid.addWidget(self.scroll_bar, 1, _COLUMNS, _ROWS, 1)
        self._facts = self.caption(name="contacts-facts")
        self._facts.setFixedHeight(_FACT_LINES * self._facts.fontMetrics().lineSpacing() + 2)
        self._estimate = self.caption(name="contacts-estimate")
        self._estimate.setToolTip(_ESTIMATE_TIP)
        for label in (self._facts, self._estimate):
            label.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.fingers = HeldFingers(self)
        self.reading = EstimationControls(self)
        self.reading.reading_edited.connect(self._on_reading_edited)
        for part in (self.fingers, self.reading):
            self.column.addWidget(part)
        self._faults = self.caption(name="contacts-faults")
        self._faults.hide()
        self._no_shear = self.caption(SHEAR_NOTE, "contacts-shear")
        self._no_shear.setToolTip(SHEAR_TIP)
        self.show_reading(ReadingSettings())
        self._use_units(self._units)
        self.clear()

    def show_reading(self, settings: ReadingSettings) -> None:
        """Show how contacts are estimated."""
        self.reading.show_reading(settings)
        self._has_estimate = settings.estimator != "area-sum"
        self._show_estimate()
        self._estimate.setFixedHeight(_ESTIMATE_LINES * self._estimate.fontMetrics().lineSpacing())

    def show_effects(self, effects: Effects) -> None:
        """Update the automatic threshold; see ``EstimationControls``."""
        self.reading.show_effects(effects)

    def show_faults(self, faults: TaxelFaults) -> None:
        """Show broken taxels and blind areas, if there are any."""
        show_text(self._faults, faults_text(faults))
        self._faults.setToolTip(faults_tip(faults))

    def set_editable(self, *, editable: bool) -> None:
        """Enable or disable the settings; contacts can always be selected."""
        self.reading.setEnabled(editable)
        self.fingers.setEnabled(editable)

    def follow(self, selection: TaxelSelection) -> None:
        """Connect the selected row with the selection of the views."""
        self.region_selected.connect(selection.select_region)
        selection.region_changed.connect(self.select_region)
        self.select_region(selection.region)

    def clear(self) -> None:
        """Remove all contacts."""
        self._regions = ()
        self._estimates = {}
        self._controlled = None
        self._notes = ()
        self._show_none()
        self._fill()

    def _show_none(self) -> None:
        self._summary.setText("No contact." if self._measured else no_contact_text(self._notes))

    def show_prepared(self, prepared: PreparedScene) -> None:
        self.fingers.show_skin(prepared.skin)
        self._show_shear(shown=False)
        self.clear()

    def show_frame(self, frame: Frame) -> None:
        """Show the regions of a frame."""
        self._regions = frame.regions
        self._estimates = frame.estimates
        self._controlled = None if frame.task is None else frame.task.controlled
        self.fingers.show_frame(frame)
        self._show_shear(shown=frame.shear is not None)
        measured = frame.measured is not None
        if (frame.units, measured) != (self._units, self._measured):
            self._use_units(frame.units, measured=measured)
        if not frame.regions:
            self.clear()
            self._notes = frame.notes
            self._show_none()
            return
        self._notes = frame.notes
        noun = "contact" if len(frame.regions) == 1 else "contacts"
        total = self._units.force_words(sum(region.force for region in frame.regions))
        words = "force unknown: not calibrated" if total is None else f"{total} in all"
        self._summary.setText(f"{len(frame.regions)} {noun}, {words}")
        self._fill()

    def _show_shear(self, *, shown: bool) -> None:
        """Show the columns of shear, or that the taxels do not measure it."""
        if shown == self._no_shear.isHidden():
            return
        self._no_shear.setHidden(shown)
        self._show_heads()
        for row in self._rows:
            row.show_shear(shown=shown)

    def _use_units(self, units: ReadingUnits, *, measured: bool = False) -> None:
        self._units = units
        self._measured = measured
        self._show_heads()
        self.reading.set_units(units, measured=measured)
        self.fingers.setHidden(measured)  # nothing is simulated that they could press
        self._show_estimate()

    def _show_heads(self) -> None:
        force = self._units.force
        last = _HEADS[self._no_shear.isHidden()]
        heads = (("On", ""), (force or "", "" if force is None else _FORCE_TIP), *last)
        for head, (text, tip) in zip(self._heads, heads, strict=True):
            head.setText(text)
            head.setToolTip(tip)
        if not self._no_shear.isHidden():
            self._heads[2].setText(self._units.unit)

    def _show_estimate(self) -> None:
        """Show the quality of the estimate, if the estimator reports it and forces are known."""
        self._estimate.setVisible(self._has_estimate and self._units.force is not None)

    def select_region(self, region: int | None) -> None:
        """Highlight the row of the region with this id, and scroll to it; None if there is none."""
        self._selected = region
        self._reveal = region is not None
        self._fill()

    def _fill(self) -> None:
        ordered = sorted(self._regions, key=lambda region: region.id)
        most = max(len(ordered) - _ROWS, 0)
        place = next((k for k, one in enumerate(ordered) if one.id == self._selected), None)
        with QSignalBlocker(self.scroll_bar):  # valueChanged would call this method again
            self.scroll_bar.setRange(0, most)
            if self._reveal and place is not None:  # once: afterwards the user may scroll away
                self._reveal = False
                self.scroll_bar.setValue(min(max(self.scroll_bar.value(), place - _ROWS + 1), place))
        self.scroll_bar.setVisible(most > 0)
        shown = ordered[self.scroll_bar.value() :]
        for number, row in enumerate(self._rows):
            region = shown[number] if number < len(shown) else None
            key = None if region is None else region.id
            row.show(
                region,
                selected=key is not None and key == self._selected,
                units=self._units,
                estimate=None if key is None else self._estimates.get(key),
                controlled=None if key is None or self._controlled is None else key in self._controlled,
            )
        self._fill_facts(min(self._regions, key=lambda region: region.id != self._selected, default=None))

    def _fill_facts(self, region: ContactRegion | None) -> None:
        """Show the facts about the selected region, or the first one."""
        parts = "" if region is None else uncertainty_text(region, self._units)
        lacking = lacking_shares(self._notes)
        self._facts.setText("" if region is None else region_summary(region, self._regions, self._units, lacking))
        shear = "" if region is None or region.shear is None else shear_text(region.shear)
        self._facts.setToolTip("\n\n".join(filter(None, (parts, shear, _FACTS_TIP))))
        estimate = None if region is None else self._estimates.get(region.id)
        self._estimate.setEnabled(estimate is not None and estimate.refused is None)
        self._estimate.setText("" if estimate is None else estimate_text(estimate, self._units))

    def _on_reading_edited(self, settings: ReadingSettings) -> None:
        self.show_reading(settings)
        self.reading_edited.emit(settings)

    def _on_row_clicked(self) -> None:
        row = next(row for row in self._rows if row.button is self.sender())
        again = row.region == self._selected
        self._fill()  # undo the toggled state of the button: only the selection sets it
        self.region_selected.emit(None if again else row.region)
