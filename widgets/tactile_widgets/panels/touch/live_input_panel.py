"""The live input: how readings of a real skin arrive, which values are shown, and which channels do not work."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QComboBox, QLabel, QPushButton, QWidget

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.core.errors import counted, names_text
from tactile_maps.live.calibration.calibration import ValueMode
from tactile_maps.live.session.connection import ConnectionState, ConnectionStatus, refused_text
from tactile_maps.live.session.facts import MeasuredFacts, few_heard
from tactile_maps.live.session.reading_gap import GapCause, PacketProblem, ReadingGap
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import ElidedLabel, add_fact, caption_label, make, push_button, row_layout
from tactile_widgets.common.note_list import Note, NoteList
from tactile_widgets.common.sentence import as_sentence
from tactile_widgets.dialogs.known_weight_dialog import KnownWeightDialog
from tactile_widgets.document.taxel_selection import TaxelSelection
from tactile_widgets.panels.touch.connected_panel import ConnectedPanel
from tactile_widgets.panels.touch.reading_distribution import ReadingDistribution
from tactile_widgets.session.live_input import LiveInput

_REFRESH_MS = 250
_JUDGED_READINGS = 20
"""Number of readings from which on taxels without a value are reported: packets may contain parts of the skin."""
_TROUBLE_LINES = 3
"""Lines of the row *Trouble*, which names as many kinds as fit."""
_MODES = {ValueMode.RAW: "Raw", ValueMode.BASELINE: "Above the baseline", ValueMode.PRESSURE: "Pressure (kPa)"}
_ROWS = {
    "state": ("State", "State of the connection; a source that breaks is opened again automatically"),
    "rate": ("Rate", "Readings per second, over the last two seconds"),
    "delay": (
        "Delay",
        "Delay beyond that of the fastest reading: median and 95th percentile of the last 1000. If it keeps growing, "
        "the sender sends later than the times in its packets state",
    ),
    "loss": ("Lost or late", "Share of the packets sent, by their sequence numbers"),
    "counts": ("Readings", "Number of readings shown, and of those that arrived and wait"),
    "trouble": (
        "Trouble",
        "Malformed, duplicated, reordered and late packets; restarts of the sender; readings combined with newer ones",
    ),
    "taxels": ("Taxels heard", "Taxels for which a value arrived"),
}
_AWAITED = "The skin is not tared. Leave it untouched and press Tare; until then no contact is detected."
_TARING = "Leave the skin untouched while its baseline is measured."
_UNHEARD = "Not heard"
_MOST_UNHEARD = 40
"""Maximum number of taxels that a note about those not heard names."""
_BROKEN = "Broken"
_SWAPPED = "Seem swapped"
_ALL_WORK = Note("All channels work", "None is broken, seems swapped or is not heard.")
_NO_NOTES = "Problems of the readings are listed here."


class LiveInputPanel(ConnectedPanel):
    """State and settings of the connection. Rows and buttons keep their places while values arrive.

    Attributes:
        weight: Dialog for a known weight; None until it is first opened.
    """

    disconnect_requested = Signal()
    """The user returns to the simulation."""
    reading_edited = Signal(ReadingSettings)
    """Contact settings entered by the user."""
    rate_changed = Signal(float)
    """Readings per second [Hz], emitted a few times per second."""
    facts_shown = Signal(MeasuredFacts)
    """Facts about the readings; emitted a few times per second."""
    gap_reported = Signal(object)
    """ReadingGap, or None while readings are used; emitted a few times per second."""
    channels_listed = Signal(QWidget)
    """The user lists the channels that do not work, in this part of the panel."""
    calibration_file_requested = Signal()
    """The user saves the gains; the receiver asks for a file and calls ``save_calibration``."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Live input", "live-input-panel", _REFRESH_MS, parent)
        self._error = ""
        self._weight_error = ""
        self.weight: KnownWeightDialog | None = None
        self._address = make(ElidedLabel, "live-address", self, role="caption")
        self.column.addWidget(self._address)
        self._baseline = caption_label(self, "live-baseline")
        self._baseline.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._baseline.setFixedHeight(2 * self._baseline.fontMetrics().lineSpacing())
        self.column.addWidget(self._baseline)
        tip = "Use the next 50 readings as those of the untouched skin"
        self._tare = push_button(self, "live-tare", "Tare", tip, self._on_tare_clicked)
        tip = "Calibrate with a known weight on the skin"
        weight = push_button(self, "live-weight", "Weight…", tip, self._on_weight_clicked)
        tip = "Close the source and simulate again"
        leave = push_button(self, "live-disconnect", "Disconnect", tip, self.disconnect_requested)
        self.column.addLayout(row_layout(self._tare, weight, leave))
        grid = self.grid()
        grid.setColumnStretch(1, 1)
        lines = (_TROUBLE_LINES - 1) * "\n"
        self._trouble = make(QLabel, lines, self, objectName="live-trouble", wordWrap=True)
        self._trouble.setFixedHeight(self._trouble.sizeHint().height())
        self._values: dict[str, QLabel] = {
            key: self._trouble if key == "trouble" else ElidedLabel(f"live-{key}", self) for key in _ROWS
        }
        for number, (key, (text, tip)) in enumerate(_ROWS.items()):
            self._values[key].setAlignment(Qt.AlignmentFlag.AlignRight)
            name = add_fact(grid, number, text, tip, self._values[key])
            name.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._mode = make(
            QComboBox, self, objectName="live-mode", accessibleName="Values shown", activated=self._on_mode_activated
        )
        self._mode.addItems(list(_MODES.values()))
        add_fact(grid, len(_ROWS), "Values", "", self._mode)
        tip = "Use a negative gain: for sensors whose values fall under pressure"
        self._inverted = push_button(self, "live-inverted", "No", tip, self._on_inverted_clicked, checkable=True)
        add_fact(grid, len(_ROWS) + 1, "Inverted", tip, self._inverted)
        tip = "List the channels that are not heard, broken (dead or stuck), or seem swapped"
        self._channels = push_button(self, "live-channels", "All work", tip, self._on_channels_clicked, checkable=True)
        add_fact(grid, len(_ROWS) + 2, "Channels", tip, self._channels)
        self._notes = NoteList("live-notes", "Problems of the readings", _NO_NOTES, self)
        self.column.addWidget(self._notes)
        self.distribution = ReadingDistribution(self)
        self.distribution.reading_edited.connect(self.reading_edited)
        self.column.addWidget(self.distribution)

    def follow(self, selection: TaxelSelection) -> None:
        super().follow(selection)
        selection.changed.connect(self._on_selection_changed)

    def _on_selection_changed(self) -> None:
        if self.weight is not None:
            self.weight.show_selected(len(self._selection.taxels))

    def set_theme(self, theme: Theme) -> None:
        self.distribution.set_theme(theme)

    def show_reading(self, settings: ReadingSettings) -> None:
        """Show the current settings of the contact detection."""
        self.distribution.show_reading(settings)

    def show_input(self, live: LiveInput | None) -> None:
        self._error = ""
        if live is None and self.weight is not None:
            self.weight.reject()
        super().show_input(live)

    def refresh(self) -> None:
        if self._input is None:
            return
        status = self._input.status
        facts, silent = self._input.facts()
        self._address.setText(status.address)
        self.rate_changed.emit(status.rate)
        gap = self._input.gap(status, facts)
        for key, text in _texts(status, facts, gap, len(self._input.origin.skin)).items():
            self._values[key].setText(text)
        self._values["state"].setToolTip("" if gap is None else as_sentence(gap.reason))
        self._show_troubles(_troubles(status, facts))
        if self.weight is not None:
            self.weight.show_facts(facts, gap, error=self._weight_error)
        if self.distribution.isVisible():
            self.distribution.show_levels(*self._input.levels())
        self._mode.setCurrentIndex(list(_MODES).index(facts.mode))
        self._show_baseline(facts, gap, over=status.state in (ConnectionState.ENDED, ConnectionState.FAILED))
        self.gap_reported.emit(gap)
        self.facts_shown.emit(facts)
        self._inverted.setChecked(facts.inverted)
        self._inverted.setText("Yes" if facts.inverted else "No")
        _request(self._inverted, requested=facts.falling)
        swapped = self._input.swapped(facts)
        self._channels.setText(_channels_text(facts, len(self._input.origin.skin)))
        notes = _notes(status, facts, self._input.problems(status, facts), len(self._input.origin.skin))
        if self._error:
            notes.insert(0, Note("Not possible", as_sentence(self._error), fault=True))
        if self._channels.isChecked():
            unheard = self._input.unheard()
            faulty = [Note(_UNHEARD, names_text(unheard, _MOST_UNHEARD))] if unheard else []
            faulty += [Note(_BROKEN, text) for text in silent] + [Note(_SWAPPED, text) for text in swapped]
            notes += faulty or [_ALL_WORK]
        if tuple(notes) != self._notes.notes:  # otherwise the list would scroll back
            self._notes.show_notes(notes)

    def _show_troubles(self, troubles: list[str]) -> None:
        """Name as many troubles as fit in the row; the tool tip names all."""
        label = self._trouble
        shown = len(troubles)
        label.setText(", ".join(troubles) or "None")
        while shown and label.heightForWidth(label.width()) > label.height():
            shown -= 1
            label.setText(", ".join([*troubles[:shown], f"+\u202f{len(troubles) - shown} more".replace(" ", "\u00a0")]))
        label.setToolTip("" if shown == len(troubles) else ", ".join(troubles))

    def _on_channels_clicked(self, listed: bool) -> None:
        """List the channels that do not work, or hide them; the list may be below the edge of the window."""
        self.refresh()
        heads = [note.head for note in self._notes.notes]
        first = next(
            (row for row, head in enumerate(heads) if head in (_UNHEARD, _BROKEN, _SWAPPED, _ALL_WORK.head)), None
        )
        if listed and first is not None:
            self._notes.scrollToItem(self._notes.item(first), NoteList.ScrollHint.PositionAtTop)
            self.channels_listed.emit(self._notes)

    def _show_baseline(self, facts: MeasuredFacts, gap: ReadingGap | None, *, over: bool) -> None:
        """Show whether the skin is tared, and draw attention to the button if it has to be.

        Args:
            facts: Facts about the readings.
            gap: Gap in the readings, for which a tare waits; None while readings are used.
            over: Whether no more readings will arrive.
        """
        text = _TARING if facts.taring else _AWAITED if facts.awaits_tare else "Not tared."
        reason = ""
        if facts.tared and not facts.taring and not facts.awaits_tare:
            text, reason = _tare_texts(facts)
        if over and (facts.taring or facts.awaits_tare):
            text = f"Not tared: the source ended after {counted(facts.readings, 'reading')}."
        elif gap is not None and facts.taring:
            text = f"The tare waits for readings: {gap.cause}."
        taring = facts.taring and not over
        self._baseline.setText(text)
        self._baseline.setToolTip(reason if gap is None else as_sentence(gap.reason))
        self._tare.setEnabled(not (facts.taring or over))
        self._tare.setText(("Taring…" if gap is None else "Waiting…") if taring else "Tare")
        _request(self._tare, requested=self._tare.isEnabled() and (facts.awaits_tare or bool(facts.held_in_tare)))

    def _on_tare_clicked(self) -> None:
        self._try(LiveInput.tare)
        self.refresh()

    def _on_inverted_clicked(self) -> None:
        self._try(LiveInput.invert)
        self.refresh()

    def _on_weight_clicked(self) -> None:
        if self.weight is None:
            self.weight = KnownWeightDialog(self)
            self.weight.measure_requested.connect(self._on_measure_requested)
            self.weight.negative_requested.connect(self._on_negative_requested)
            self.weight.undo_requested.connect(self._on_undo_requested)
            self.weight.save_requested.connect(self.calibration_file_requested)
            self.weight.finished.connect(self._on_weight_closed)
        self._on_selection_changed()
        self.refresh()
        self.weight.show()

    def _on_weight_closed(self) -> None:
        self._weight_error = self._try(LiveInput.forget_weighing)

    def _on_measure_requested(self, mass: float, seconds: float) -> None:
        chosen = self._selection.taxels if len(self._selection.taxels) else None
        self._weigh(lambda live: live.begin_weighing(mass, seconds, chosen))

    def _on_negative_requested(self) -> None:
        self._weigh(LiveInput.apply_negative_gain)

    def _on_undo_requested(self) -> None:
        self._weigh(LiveInput.undo_weighing)

    def save_calibration(self, path: str) -> None:
        """Write the gains and offsets; show an error in the dialog of the known weight."""
        self._weigh(lambda live: live.save_calibration(path))

    def _weigh(self, act: Callable[[LiveInput], None]) -> None:
        """Do what the dialog of the weight requests; it shows errors."""
        self._weight_error = self._try(act)
        self.refresh()

    def _on_mode_activated(self, index: int) -> None:
        self._error = self._try(lambda live: live.request_mode(list(_MODES)[index]))
        self.refresh()


def _request(button: QPushButton, *, requested: bool) -> None:
    """Draw attention to a button, or stop doing so."""
    role = "requested" if requested else ""
    if button.property("role") != role:
        button.setProperty("role", role)
        button.style().polish(button)


def _texts(status: ConnectionStatus, facts: MeasuredFacts, gap: ReadingGap | None, taxels: int) -> dict[str, str]:
    counts = status.counts
    delay = status.delay
    state = status.state.value.capitalize()
    if status.state is ConnectionState.RECONNECTING and status.next_try is not None:
        state = f"Reconnecting in {status.next_try:.1f}\u202fs"
    elif gap is not None and gap.cause is GapCause.REJECTED:
        state = gap.cause.value.capitalize()
    return {
        "state": state,
        "rate": f"{status.rate:.0f}\u202fHz",
        "delay": "–" if delay is None else f"{1e3 * delay.median:.1f}, {1e3 * delay.p95:.1f}\u202fms",
        "loss": f"{100 * counts.loss:.2g}\u202f%",
        "counts": f"{facts.readings}, {status.waiting} wait" if status.waiting else str(facts.readings),
        "taxels": f"{taxels - facts.unheard} of {taxels}",
    }


def _troubles(status: ConnectionStatus, facts: MeasuredFacts) -> list[str]:
    """Return the troubles with their counts; a line is not broken within one."""
    kinds = ("malformed", "duplicated", "reordered", "late", "restarts", "overflowed", "superseded")
    trouble = {"rejected": facts.refused} | {name: getattr(status.counts, name) for name in kinds}
    trouble |= {"mistimed": facts.mistimed, "combined": facts.combined, "reconnects": status.reconnects}
    return [_counted(number, name).replace(" ", "\u00a0") for name, number in trouble.items() if number]


def _tare_texts(facts: MeasuredFacts) -> tuple[str, str]:
    """Return how the tare went, and the taxels that were touched during it."""
    if facts.held_in_tare:
        touched = counted(len(facts.held_in_tare), "taxel")
        return f"Tared, but {touched} seemed touched during the tare: tare again.", names_text(facts.held_in_tare)
    if facts.touched_in_tare:
        touched = counted(len(facts.touched_in_tare), "taxel")
        return f"Tared; {touched} touched during a part of the tare.", names_text(facts.touched_in_tare)
    return "Tared.", ""


def _counted(number: int, name: str) -> str:
    """Return a number with the name of its trouble; names of events are nouns in the plural."""
    return counted(number, name.removesuffix("s")) if name.endswith("s") else f"{number} {name}"


def _channels_text(facts: MeasuredFacts, taxels: int) -> str:
    """Return in words how many channels do not work."""
    if facts.unheard == taxels:
        return "None heard"
    texts = {
        f"{facts.unheard} not heard": facts.unheard,
        f"{len(facts.silent)} broken": len(facts.silent),
        counted(len(facts.swapped), "swapped pair"): len(facts.swapped),
    }
    return ", ".join(text for text, count in texts.items() if count) or "All work"


def _notes(
    status: ConnectionStatus, facts: MeasuredFacts, problems: tuple[PacketProblem, ...], taxels: int
) -> list[Note]:
    """Return warnings and problems; problems that are over are no faults and state their age."""
    notes = [Note("Problem", as_sentence(status.problem), fault=True)] if status.problem else []
    notes += [Note("Problem", as_sentence(one.text), fault=True) for one in problems if not one.over]
    earlier = [Note(f"Earlier problem, {one.age}", as_sentence(one.text)) for one in problems if one.over]
    if status.refused:
        notes.append(Note("Rejected packets of a second sender", refused_text(status.refused)))
    over = status.state is ConnectionState.ENDED
    few = few_heard(facts, taxels) if facts.readings >= (1 if over else _JUDGED_READINGS) else None
    if few:
        cure = "They may be of another skin: open the skin or taxel file that belongs to them, then connect again."
        notes.append(Note("Taxels without a value", f"{as_sentence(few)}. {cure}", fault=True))
    if facts.readings and facts.known and not facts.calibrated:
        notes.append(Note("No forces", "Choose Pressure (kPa) under Values to show calibrated pressures and forces."))
    elif facts.readings and not facts.calibrated:
        notes.append(Note("Not calibrated", "Readings are shown in counts, and no forces are shown."))
    if facts.falling:
        cure = "If they fall under pressure, press Inverted. If the skin was touched during the tare, repeat the tare."
        names = names_text(facts.falling_taxels)
        notes.append(Note("Neighbouring taxels fall below their baseline", f"{names}. {cure}", fault=True))
    if facts.touched_in_tare:
        text = f"The readings meanwhile were left out for {names_text(facts.touched_in_tare)}."
        notes.append(Note("Touched during the tare", text))
    if facts.held_in_tare:
        text = (
            f"{names_text(facts.held_in_tare)}. If something touched them, contacts there are hidden: repeat the tare."
        )
        notes.append(Note("Neighbouring taxels read far more than the others during the tare", text, fault=True))
    if facts.unknown:
        notes.append(Note("Taxels that the skin does not have", names_text(facts.unknown)))
    if facts.ambiguous:
        notes.append(Note("Ids that several taxels have", f"{names_text(facts.ambiguous)}; name them link:id"))
    if facts.wrong_channels:
        notes.append(Note("Taxels with a wrong number of channels", names_text(facts.wrong_channels)))
    if facts.unknown_joints:
        notes.append(Note("Joints that the robot does not have", names_text(facts.unknown_joints)))
    return notes + earlier
