"""The effects panel: what this scene simulates, why, what each effect costs, and a way to override it.

First what an effect may be set to and its reason in words, then its cost (stages as they run here; the rest as measured
in another process), both without Qt; then a row, and the panel.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtGui import QFocusEvent, QFont, QMouseEvent, QPalette, QResizeEvent
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QPushButton, QSizePolicy, QVBoxLayout, QWidget

from tactile_maps.core.errors import Finding
from tactile_maps.core.timing import Timings
from tactile_maps.scene.effect_decision import EffectDecision, EffectRow
from tactile_maps.scene.effects import EFFECTS, EffectEntry, Effects, Override
from tactile_maps.scene.scene import Scene, with_override
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind, contact_note_text
from tactile_widgets.common.panel import CollapsibleHeading, FlatComboBox, Panel, value_label

AUTO = "auto"
_TIME_STEPS = (0.0005, 0.001, 0.002, 0.0025, 0.004, 0.005, 0.008, 0.01, 0.02)
"""Time steps that are offered [s], where a tick is a whole number of them."""
EffectChoices = tuple[tuple[str, Override], ...]


def effect_choices(key: str, *, tick: float) -> EffectChoices:
    """(words, wish) of all that an effect may be set to, ``auto`` first.

    Args:
        key: Of ``EFFECTS``.
        tick: Of the scene [s].
    """
    entry = EFFECTS[key]
    if entry.choices:
        return (("Auto", AUTO), *((choice, choice) for choice in entry.choices))
    return (("Auto", AUTO), *((entry.word(step), step) for step in _time_steps(entry, tick)))


def _time_steps(entry: EffectEntry, tick: float) -> list[float]:
    low, high = entry.range
    return [step for step in _TIME_STEPS if low <= step <= high and abs(tick / step - round(tick / step)) < 1e-6]


def automatic_rows(scene: Scene) -> dict[str, EffectRow]:
    """Each effect as it would be if it alone followed from what the scene is for. Cost: 0.1 ms a wish."""
    rows = {row.name: row for row in scene.decision.rows}
    for key in scene.overrides:
        auto = with_override(scene, key, AUTO).decision
        rows[key] = next(row for row in auto.rows if row.name == key)
    return rows


def recorded_decision(scene: Scene, effects: Effects) -> EffectDecision:
    """What is simulated, where that may differ from what the scene decides: it was changed while it was recorded."""
    decision = scene.decision
    if effects == decision.effects:
        return decision
    rows = []
    for row in decision.rows:
        entry = EFFECTS[row.name]
        old, new = (entry.value_in(part) for part in (decision.effects, effects))
        word = entry.word(new)
        changed = replace(row, on=word != "off", value=word, why="changed during the recording", overridden=True)
        rows.append(row if old == new else changed)
    return EffectDecision(effects, tuple(rows), ())


def credited_decision(decision: EffectDecision, opened: Scene, scene: Scene) -> EffectDecision:
    """The same decision, with a person named where it was not the scene that was opened who said so."""
    here = {key for key, wish in scene.overrides.items() if opened.overrides.get(key) != wish}
    rows = (replace(row, why="set by user") if row.name in here else row for row in decision.rows)
    return replace(decision, rows=tuple(rows))


def effect_tip(row: EffectRow, auto: EffectRow) -> str:
    """What the effect does, and why it is as it is; of one that is off also what it would usually be."""
    entry = EFFECTS[row.name]
    usual = ", ".join(f"{key.replace('_', ' ')} {value:g}" for key, value in entry.options.items())
    off = f"\nDefault: {usual}." if usual and not row.on else ""
    return f"{entry.tip}.\n{effect_reason(row, auto)}{off}"


def effect_reason(row: EffectRow, auto: EffectRow) -> str:
    """The reason in a sentence; of what was overridden also what it would be by itself, and why."""
    why = row.why[:1].upper() + row.why[1:]
    return f"{why}; auto is {auto.value}: {auto.why}." if row.overridden else f"{why}."


_WINDOW = 120
_SMALLEST_MS = 0.005
"""Milliseconds below which two digits say nothing; a difference may even be negative, lost in the noise."""
_STAGES = {"skin": "touch"}
"""Stages that are called otherwise than their effect."""
_LIVE = "Median of the last {count} ticks, as it runs now"
_MEASURED_OFFLINE = "Measured by ablation in a separate process"


@dataclass(frozen=True)
class CostText:
    """Milliseconds a tick in words; ``beside`` if they were not measured in the session that runs."""

    words: str
    beside: bool
    tip: str


class EffectCosts:
    """Collects stage times. Mutable: ``add`` ticks, set ``prices``.

    Attributes:
        prices: Milliseconds a tick by key of an effect, for those that are no stage of their own.
    """

    def __init__(self) -> None:
        self.prices: Mapping[str, float] = {}
        self.clear(0.0)

    def clear(self, tick: float) -> None:
        """Forget another scene's times; ``tick`` is the new one's [s]."""
        self._tick = tick
        self.prices = {}
        self._stages: dict[str, deque[float]] = {}
        self._totals: deque[float] = deque(maxlen=_WINDOW)

    def add(self, timings: Timings) -> None:
        """Take one tick's stage times."""
        for stage, milliseconds in timings.ms.items():
            self._stages.setdefault(stage, deque(maxlen=_WINDOW)).append(milliseconds)
        for stage in [stage for stage in self._stages if stage not in timings.ms]:
            del self._stages[stage]  # switched off: what it cost is of another state
        self._totals.append(timings.total_ms)

    def of(self, row: EffectRow) -> CostText:
        """What an effect costs now."""
        if not row.on:
            return CostText("–", False, "Off: it costs nothing")
        times = self._stages.get(_STAGES.get(row.name, row.name))
        if times:
            return CostText(_format_ms(float(np.median(times))), False, _LIVE.format(count=len(times)))
        if row.name in self.prices:
            return CostText(_format_ms(self.prices[row.name]), True, _MEASURED_OFFLINE)
        if self.prices:
            return CostText("–", True, "It cannot be switched off, so its cost cannot be measured")
        return CostText("…", True, "Measuring in a separate process")

    @property
    def total(self) -> str:
        """All of a tick, beside the time there is for it in real time; empty before the first tick."""
        if not self._totals:
            return ""
        return f"{float(np.median(self._totals)):.2f} of {1e3 * self._tick:g}\u202fms a tick"


def _format_ms(milliseconds: float) -> str:
    return f"<{2 * _SMALLEST_MS:.2f}" if milliseconds < _SMALLEST_MS else f"{milliseconds:.2f}"


_CHOICE_PX = 110
_CHOICE_HIGH_PX = 23
_COST_PX = 44
_MARK_PX = 12
_SCROLL_PX = 16
_MARK = "●"
_DOT_PX = 8


class EffectRowWidget(QWidget):
    """A row: a dot for what does not follow from the scene, the name, a box to choose from, milliseconds a tick.

    Args:
        key: Of the effect.
        choices: What it may be set to, ``auto`` first.
        parent: Qt parent.
    """

    chosen = Signal(str, object)
    """Key and wish: what a person asked for."""
    selected = Signal(str)
    """The user or the keys came here."""

    def __init__(self, key: str, choices: EffectChoices, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.key = key
        self._index = 0
        self._title = ""
        self.setObjectName(f"effect-{key}")
        self._mark, self._name, self._why = QLabel(self), QLabel(self), QLabel(self)
        self.box, self._cost = FlatComboBox(self), value_label("–", self, right=True)
        for words, wish in choices:
            self.box.addItem(words, wish)
        self.box.setObjectName(f"effect-{key}-choice")
        self.box.setFixedSize(_CHOICE_PX, _CHOICE_HIGH_PX)
        self.box.activated.connect(self._on_activated)
        self.box.installEventFilter(self)
        self._cost.setFixedWidth(_COST_PX)
        self._cost.setObjectName(f"effect-{key}-cost")
        self._mark.setForegroundRole(QPalette.ColorRole.Link)
        self._mark.setFixedWidth(_MARK_PX)
        dot = QFont(self.font())
        dot.setPixelSize(_DOT_PX)
        self._mark.setFont(dot)
        self._name.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self._why.setProperty("role", "caption")
        self._why.setWordWrap(True)
        self._why.setMinimumWidth(1)
        self._why.hide()
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(0)
        grid.setVerticalSpacing(2)
        for column, widget in enumerate((self._mark, self._name, self.box, self._cost)):
            grid.addWidget(widget, 0, column)
        grid.addWidget(self._why, 1, 1, 1, 3)
        grid.setColumnStretch(1, 1)

    @property
    def words(self) -> tuple[str, str, str]:
        """Name, value and cost, as they are shown."""
        return self._title, self.box.words, self._cost.text()

    @property
    def marked(self) -> bool:
        """Whether it is marked as set by a person or the scene."""
        return bool(self._mark.text())

    @property
    def why(self) -> str:
        """The reason that is shown; empty while it is not selected."""
        return "" if self._why.isHidden() else self._why.text()

    def show_row(self, row: EffectRow, auto: EffectRow) -> None:
        """Show the effect as it is now, and as it would be by itself."""
        self._title = row.title
        self._elide()
        self._index = self.box.findText(row.value) if row.overridden else 0
        self.box.setItemText(0, f"Auto ({auto.value})")
        self.box.setCurrentIndex(self._index)
        self.box.view().setMinimumWidth(self.box.view().sizeHintForColumn(0) + _SCROLL_PX)
        self.box.say(row.value, quiet=not row.on)
        self.box.setAccessibleName(row.title)
        self._mark.setText(_MARK if row.overridden else "")
        self._why.setText(effect_reason(row, auto))
        for widget in (self, self._name, self.box):
            widget.setToolTip(effect_tip(row, auto))

    def show_cost(self, words: str, *, beside: bool, tip: str) -> None:
        """Show what it costs; ``beside`` for what was measured in another process instead of here and now."""
        self._cost.setText(words)
        self._cost.setForegroundRole(QPalette.ColorRole.PlaceholderText if beside else QPalette.ColorRole.WindowText)
        self._cost.setToolTip(tip)

    def select(self, *, selected: bool) -> None:
        """Show the reason, or not."""
        self._why.setVisible(selected)

    def _on_activated(self, index: int) -> None:
        wish = self.box.itemData(index)
        self.box.setCurrentIndex(self._index)  # it says what is in force, until that has changed
        if index != self._index:
            self.chosen.emit(self.key, wish)

    def _elide(self) -> None:
        self._name.setText(
            self._name.fontMetrics().elidedText(self._title, Qt.TextElideMode.ElideRight, self._name.width())
        )

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Qt: the keys came to the box."""
        if event.type() == QEvent.Type.FocusIn and isinstance(event, QFocusEvent):
            self.selected.emit(self.key)
        return super().eventFilter(watched, event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Qt: a press beside the box selects the row."""
        self.selected.emit(self.key)
        event.accept()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Qt: names are cut where there is no room."""
        super().resizeEvent(event)
        self._elide()


_REFRESH_EVERY = 15
_WARNING = "⚠"


_IN_RECORDING = "Effects used in the recording."


class EffectsPanel(Panel):
    """A row an effect: its state, its milliseconds a tick, a box that overrides it. Decides nothing.

    What is measured where it runs is shown plainly; what was measured in a process beside, quietly.
    """

    wished = Signal(str, object)
    """Key and wish: a person wants an effect otherwise; ``auto`` for as the scene needs it."""
    auto_all_requested = Signal()
    """All of them as the scene needs them."""

    simulates = True

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Effects", "effects-panel", parent)
        self._empty = self.caption("Open a scene to see its simulated effects.")
        self._costs = EffectCosts()
        self._decision: EffectDecision | None = None
        self._lines: dict[str, EffectRowWidget] = {}
        self._listed = 0.0  # the tick whose choices they have [s]
        self._count = 0
        self._open = True
        self._content = QWidget(self)
        self.column.addWidget(self._content)
        self._rows = QVBoxLayout(self._content)
        self._rows.setContentsMargins(0, 0, 0, 0)
        self._rows.setSpacing(2)
        self._warnings = self._note("effects-warnings")
        self._closed = self._note("effects-closed")
        self._closed.setText(_IN_RECORDING)
        self._rows.addLayout(self._header())
        self._body = QWidget(self._content)
        self._sensor = QWidget(self._content)
        self._columns = {group: _group_layout(group) for group in (self._body, self._sensor)}
        self._fold = CollapsibleHeading("Sensor", self._content)
        self._fold.setObjectName("effects-sensor-heading")
        self._fold.toggled.connect(self._sensor.setHidden)
        self._fold.setChecked(True)
        self._rows.addWidget(self._body)
        self._rows.addSpacing(6)
        for widget in (self._fold, self._sensor):
            self._rows.addWidget(widget)
        self._total = value_label("", self._content, right=True)
        self._total.setObjectName("effects-total")
        self._auto = QPushButton("Reset all to auto", self._content)
        self._auto.setObjectName("effects-all-auto")
        self._auto.setToolTip("Set every effect to what the scene needs")
        self._auto.clicked.connect(self.auto_all_requested)
        self._rows.addSpacing(8)
        self._rows.addLayout(self._footer())
        self._notes = self._note("effects-notes")
        self._since_shown: dict[tuple[ContactNoteKind, tuple[str, ...]], ContactNote] = {}
        for label in (self._closed, self._notes):
            label.setProperty("role", "caption")
        self._content.hide()

    def show_prepared(self, prepared: PreparedScene) -> None:
        """List the effects of another scene."""
        self._empty.hide()
        self._content.show()
        self._costs.clear(prepared.scene.tick)
        if prepared.scene.tick != self._listed:
            self._list_effects(prepared.scene.tick)
        self.show_decision(prepared.scene.decision, automatic_rows(prepared.scene))

    def _list_effects(self, tick: float) -> None:
        """A row for each, with what can be chosen at a tick [s]. Cost: 60 ms, more than all else of the panel."""
        self._listed = tick
        for line in self._lines.values():
            line.hide()  # it is deleted only when the events come round, and would lie over its successor
            line.deleteLater()
        self._lines = {}
        before: dict[QWidget, QWidget] = {self._body: self.help, self._sensor: self._fold}
        for key in EFFECTS:
            group = self._sensor if EFFECTS[key].of_sensor else self._body
            line = EffectRowWidget(key, effect_choices(key, tick=tick), group)
            line.chosen.connect(self.wished)
            line.selected.connect(self._on_selected)
            self._columns[group].addWidget(line)
            self._lines[key] = line
            QWidget.setTabOrder(before[group], line.box)  # they come long after all that stands below them
            before[group] = line.box

    def show_decision(
        self, decision: EffectDecision, autos: Mapping[str, EffectRow], *, notes: Sequence[Finding] = ()
    ) -> None:
        """Show what is simulated now, and what is wrong with it.

        Args:
            decision: What is simulated.
            autos: Each effect as it would be by itself, by key.
            notes: Warnings beside those of the decision.
        """
        self._decision = decision
        for row in decision.rows:
            self._lines[row.name].show_row(row, autos[row.name])
        self.set_editable(editable=self._open)
        warnings = [finding.action for finding in (*decision.warnings, *notes)]
        self._warnings.setText("\n".join(f"{_WARNING} {words}." for words in warnings))
        self._warnings.setVisible(bool(warnings))
        self.refresh()

    def show_prices(self, prices: dict[str, float]) -> None:
        """Milliseconds a tick by key, as measured beside."""
        self._costs.prices = prices
        self.refresh()

    def show_frame(self, frame: Frame) -> None:
        """Take a frame's stage times; shown a few times a second, so that digits can be read."""
        self._costs.add(frame.timings)
        self._count += 1
        for note in frame.notes:  # some last a tick
            self._since_shown[note.kind, note.bodies] = note
        if self._count % _REFRESH_EVERY == 1 and self.isVisible():
            self.refresh()
            self._notes.setText("\n".join(map(contact_note_text, self._since_shown.values())))
            self._notes.setVisible(bool(self._since_shown))
            self._since_shown.clear()

    def set_editable(self, *, editable: bool) -> None:
        """Take wishes, or only show, as while replaying."""
        self._open = editable
        self._closed.setVisible(not editable)
        for line in self._lines.values():
            line.box.setEnabled(editable)
        rows = () if self._decision is None else self._decision.rows
        self._auto.setEnabled(editable and any(row.overridden for row in rows))

    def show_reason(self, text: str) -> None:
        """Say why nothing can be changed: in a replay, because it is one."""
        self._closed.setText(text or _IN_RECORDING)

    def refresh(self) -> None:
        """Show costs now."""
        if self._decision is None:
            return
        for row in self._decision.rows:
            cost = self._costs.of(row)
            self._lines[row.name].show_cost(cost.words, beside=cost.beside, tip=cost.tip)
        self._total.setText(self._costs.total)
        on = sum(row.on for row in self._decision.rows if EFFECTS[row.name].of_sensor)
        self._fold.setText(f"Sensor  ·  {on} on" if on else "Sensor  ·  ideal")

    @property
    def lines(self) -> dict[str, EffectRowWidget]:
        """The rows by key."""
        return self._lines

    def _note(self, name: str) -> QLabel:
        label = QLabel(self._content)
        label.setObjectName(name)
        label.setWordWrap(True)
        label.setMinimumWidth(1)
        label.hide()
        self._rows.addWidget(label)
        return label

    def _header(self) -> QHBoxLayout:
        row = QHBoxLayout()
        for words, side in (("Effect", Qt.AlignmentFlag.AlignLeft), ("ms per tick", Qt.AlignmentFlag.AlignRight)):
            label = QLabel(words, self._content)
            label.setProperty("role", "caption")
            row.addWidget(label, 0, side)
        return row

    def _footer(self) -> QHBoxLayout:
        row = QHBoxLayout()
        row.addWidget(self._auto)
        row.addWidget(self._total, 1)
        return row

    def _on_selected(self, key: str) -> None:
        for name, line in self._lines.items():
            line.select(selected=name == key)


def _group_layout(group: QWidget) -> QVBoxLayout:
    column = QVBoxLayout(group)
    column.setContentsMargins(0, 0, 0, 0)
    column.setSpacing(2)
    return column
