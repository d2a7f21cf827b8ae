"""The live input: how readings of a real skin arrive, what is shown of them, and which channels say nothing."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QPushButton, QWidget

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.live.channels.calibration import ValueMode
from tactile_maps.live.session.connection import ConnectionState, ConnectionStatus, refused_text
from tactile_maps.live.session.measured_session import MeasuredFacts
from tactile_widgets.common.panel import Panel, value_label
from tactile_widgets.common.sentence import as_sentence
from tactile_widgets.dialogs.known_weight_dialog import KnownWeightDialog
from tactile_widgets.document.taxel_selection import TaxelSelection
from tactile_widgets.session.live_input import LiveInput

_REFRESH_MS = 250
_NAMED = 6
_MODES = {ValueMode.RAW: "Raw", ValueMode.BASELINE: "Above the baseline", ValueMode.PRESSURE: "Pressure (kPa)"}
_ROWS = {
    "state": ("State", "Of the connection; a source that breaks is opened again by itself"),
    "rate": ("Rate", "Readings a second, over the last two seconds"),
    "delay": ("Delay", "Beyond the quickest reading: median and 95th percentile of the last 1000"),
    "loss": ("Lost or late", "Share of the packets sent, by their running numbers"),
    "counts": ("Readings", "That were shown"),
    "trouble": ("Trouble", "Malformed, duplicated, reordered and late packets; restarts of the sender"),
    "taxels": ("Taxels heard", "That a value came for"),
}


class LiveInputPanel(Panel):
    """Hidden while nothing is connected.

    Attributes:
        weight: Asks for a known weight; None until it is first wanted.
    """

    disconnect_wanted = Signal()
    """Go back to simulating."""
    rate_changed = Signal(float)
    """Readings a second [Hz], a few times a second."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Live input", "live-input-panel", parent)
        self._input: LiveInput | None = None
        self._selection: TaxelSelection | None = None
        self._error = ""
        self._weight_error = ""
        self.weight: KnownWeightDialog | None = None
        self._address = self.caption()
        grid = self.grid()
        grid.setColumnStretch(1, 1)
        self._values: dict[str, QLabel] = {}
        for row, (key, (text, tip)) in enumerate(_ROWS.items()):
            name = value_label(text, self)
            value = value_label("–", self, right=True)
            name.setToolTip(tip)
            value.setObjectName(f"live-{key}")
            grid.addWidget(name, row, 0)
            grid.addWidget(value, row, 1)
            self._values[key] = value
        self._values["trouble"].setWordWrap(True)
        self._mode = QComboBox(self)
        self._mode.setObjectName("live-mode")
        self._mode.setAccessibleName("Values shown")
        self._mode.addItems(list(_MODES.values()))
        self._mode.activated.connect(self._on_mode_activated)
        grid.addWidget(value_label("Values", self), len(_ROWS), 0)
        grid.addWidget(self._mode, len(_ROWS), 1)
        self._notes = self.caption()
        self._notes.setObjectName("live-notes")
        self.column.addLayout(self._buttons())
        self._timer = QTimer(self)
        self._timer.setInterval(_REFRESH_MS)
        self._timer.timeout.connect(self.refresh)
        self.hide()

    def _buttons(self) -> QHBoxLayout:
        row = QHBoxLayout()
        self._tare = QPushButton("Tare", self)
        self._tare.setObjectName("live-tare")
        self._tare.setToolTip("Take the next 50 readings as those of the untouched skin")
        self._tare.clicked.connect(self._on_tare_clicked)
        leave = QPushButton("Disconnect", self)
        leave.setObjectName("live-disconnect")
        leave.setToolTip("Close the source and simulate again")
        leave.clicked.connect(self.disconnect_wanted)
        self._weight = QPushButton("Weight…", self)
        self._weight.setObjectName("live-weight")
        self._weight.setToolTip("Calibrate by a known weight that lies on the skin")
        self._weight.clicked.connect(self._on_weight_clicked)
        for button in (self._tare, self._weight, leave):
            row.addWidget(button)
        return row

    def follow(self, selection: TaxelSelection) -> None:
        """A weight lies on what is selected there, if anything is."""
        self._selection = selection
        selection.changed.connect(self._on_selection_changed)

    def _on_selection_changed(self) -> None:
        if self.weight is not None:
            self.weight.show_selected(0 if self._selection is None else len(self._selection.taxels))

    def show_input(self, live: LiveInput | None) -> None:
        """Show another live input; None for none."""
        self._input = live
        self._error = ""
        if live is None and self.weight is not None:
            self.weight.reject()
        self.setVisible(live is not None)
        if live is None:
            self._timer.stop()
        else:
            self._timer.start()
            self.refresh()

    def refresh(self) -> None:
        """Show how things are now."""
        if self._input is None:
            return
        status = self._input.status
        facts, silent = self._input.facts()
        self._address.setText(status.address)
        self.rate_changed.emit(status.rate)
        for key, text in _texts(status, facts, len(self._input.origin.skin)).items():
            self._values[key].setText(text)
        if self.weight is not None:
            self.weight.show_facts(facts, error=self._weight_error)
        self._mode.setCurrentIndex(list(_MODES).index(facts.mode))
        self._tare.setEnabled(not facts.taring)
        self._tare.setText("Taring…" if facts.taring else "Tare")
        self._notes.setText(
            "\n".join(
                filter(None, (as_sentence(self._error), *_notes(status, facts, silent, self._input.swapped(facts))))
            )
        )
        self._notes.setHidden(not self._notes.text())

    def _on_tare_clicked(self) -> None:
        if self._input is not None:
            self._input.tare()
            self.refresh()

    def _on_weight_clicked(self) -> None:
        if self.weight is None:
            self.weight = KnownWeightDialog(self)
            self.weight.measure_wanted.connect(self._on_measure_wanted)
            self.weight.undo_wanted.connect(self._on_undo_wanted)
            self.weight.save_wanted.connect(self._on_save_wanted)
        self._weight_error = ""
        self._on_selection_changed()
        self.refresh()
        self.weight.show()

    def _on_measure_wanted(self, mass: float, seconds: float) -> None:
        chosen = None if self._selection is None or not len(self._selection.taxels) else self._selection.taxels
        self._ask(lambda live: live.begin_weighing(mass, seconds, chosen))

    def _on_undo_wanted(self) -> None:
        self._ask(lambda live: live.undo_weighing())

    def _on_save_wanted(self, path: str) -> None:
        self._ask(lambda live: live.save_calibration(path))

    def _ask(self, act: Callable[[LiveInput], None]) -> None:
        """What the weight's dialog wants; why it is refused is said there."""
        self._weight_error = ""
        if self._input is not None:
            try:
                act(self._input)
            except TactileMapsError as error:
                self._weight_error = str(error)
        self.refresh()

    def _on_mode_activated(self, index: int) -> None:
        if self._input is None:
            return
        try:
            self._input.request_mode(list(_MODES)[index])
            self._error = ""
        except TactileMapsError as error:
            self._error = str(error)
        self.refresh()


def _texts(status: ConnectionStatus, facts: MeasuredFacts, taxels: int) -> dict[str, str]:
    counts = status.counts
    delay = status.delay
    state = status.state.value.capitalize()
    if status.state is ConnectionState.RECONNECTING and status.next_try is not None:
        state = f"Reconnecting in {status.next_try:.1f}\u202fs"
    trouble = {name: getattr(counts, name) for name in ("malformed", "duplicated", "reordered", "late", "restarts")}
    trouble |= {"overflowed": counts.overflowed, "refused": facts.refused, "mistimed": facts.mistimed}
    trouble |= {"reconnects": status.reconnects}
    return {
        "state": state,
        "rate": f"{status.rate:.0f}\u202fHz",
        "delay": "–" if delay is None else f"{1e3 * delay.median:.1f}, {1e3 * delay.p95:.1f}\u202fms",
        "loss": f"{100 * counts.loss:.2g}\u202f%",
        "counts": str(facts.readings),
        "trouble": ", ".join(f"{number} {name}" for name, number in trouble.items() if number) or "None",
        "taxels": f"{taxels - facts.unheard} of {taxels}",
    }


def _notes(
    status: ConnectionStatus, facts: MeasuredFacts, silent: tuple[str, ...], swapped: tuple[str, ...]
) -> list[str]:
    """What a person should know or do."""
    notes = [as_sentence(text) for text in (status.problem, facts.problem, status.malformed) if text]
    if status.refused:
        notes.append(f"Packets of a second sender were refused: {refused_text(status.refused)}")
    if facts.readings and not facts.calibrated:
        notes.append("Not calibrated: readings are shown in counts, and no forces are shown.")
    if facts.unknown:
        notes.append(f"Taxels that the skin does not have: {_named(facts.unknown)}")
    if facts.unknown_joints:
        notes.append(f"Joints that the robot does not have: {_named(facts.unknown_joints)}")
    if silent:
        notes.append(f"Channels that say nothing ({len(silent)}): {_named(silent)}")
    if swapped:
        notes.append(f"Channels that seem swapped ({len(facts.swapped)}): {_named(swapped)}")
    return notes


def _named(names: tuple[str, ...]) -> str:
    more = len(names) - _NAMED
    return ", ".join(names[:_NAMED]) + (f" and {more} more" if more > 0 else "")
