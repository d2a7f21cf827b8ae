"""The effects panel: the simulated effects of a scene with reason and cost, and a choice that overrides each.

The module begins with the choices and reasons of an effect, and its cost (stages as measured in this session, others as
measured in a separate process), both without Qt; then follow a row and the panel.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtGui import QFocusEvent, QMouseEvent, QPalette, QResizeEvent
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QWidget

from tactile_maps.core.errors import Finding
from tactile_maps.core.timing import Timings
from tactile_maps.scene.effect_decision import EffectDecision, EffectRow
from tactile_maps.scene.effects import EFFECTS, EffectEntry, Effects, Override
from tactile_maps.scene.scene import Scene, with_override
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind, contact_note_text
from tactile_widgets.common.make import (
    add_items,
    column_layout,
    make,
    push_button,
    row_layout,
    show_text,
    small_font,
    value_label,
)
from tactile_widgets.common.panel import CollapsibleHeading, FlatComboBox, Panel
from tactile_widgets.common.sentence import capitalized

AUTO = "auto"
_TIME_STEPS = (0.0005, 0.001, 0.002, 0.0025, 0.004, 0.005, 0.008, 0.01, 0.02)
"""Offered time steps [s], if a tick is a whole number of them."""
EffectChoices = tuple[tuple[str, Override], ...]


def effect_choices(key: str, *, tick: float) -> EffectChoices:
    """Return (text, override) of the choices for an effect, ``auto`` first.

    Args:
        key: Key in ``EFFECTS``.
        tick: Tick of the scene [s].
    """
    entry = EFFECTS[key]
    if entry.choices:
        return (("Auto", AUTO), *((choice, choice) for choice in entry.choices))
    return (("Auto", AUTO), *((entry.word(step), step) for step in _time_steps(entry, tick)))


def _time_steps(entry: EffectEntry, tick: float) -> list[float]:
    low, high = entry.range
    return [step for step in _TIME_STEPS if low <= step <= high and abs(tick / step - round(tick / step)) < 1e-6]


def automatic_rows(scene: Scene) -> dict[str, EffectRow]:
    """Return each effect as it would be without its override. Cost: 0.1 ms per override."""
    rows = {row.name: row for row in scene.decision.rows}
    for key in scene.overrides:
        auto = with_override(scene, key, AUTO).decision
        rows[key] = next(row for row in auto.rows if row.name == key)
    return rows


def recorded_decision(scene: Scene, effects: Effects) -> EffectDecision:
    """Return the decision for effects that may differ from those of the scene because of changes while recording."""
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


def measured_decision(decision: EffectDecision) -> EffectDecision:
    """Return the decision of readings, whose time step no one chose: it is the resolution of their times."""
    why = "times of readings are multiples of it, and nothing is simulated"
    rows = (replace(row, why=why, overridden=False) if row.name == "timestep" else row for row in decision.rows)
    return replace(decision, rows=tuple(rows))


def credited_decision(decision: EffectDecision, opened: Scene, scene: Scene) -> EffectDecision:
    """Return the decision with the user as reason of overrides that the opened scene does not contain."""
    here = {key for key, override in scene.overrides.items() if opened.overrides.get(key) != override}
    rows = (replace(row, why="set by user") if row.name in here else row for row in decision.rows)
    return replace(decision, rows=tuple(rows))


def effect_tip(row: EffectRow, auto: EffectRow) -> str:
    """Return the description and reason of an effect; for one that is off also its usual options."""
    entry = EFFECTS[row.name]
    usual = ", ".join(f"{key.replace('_', ' ')} {value:g}" for key, value in entry.options.items())
    off = f"\nDefault: {usual}." if usual and not row.on else ""
    return f"{entry.tip}.\n{effect_reason(row, auto)}{off}"


def effect_reason(row: EffectRow, auto: EffectRow) -> str:
    """Return the reason in a sentence; for an overridden effect also the automatic value and its reason."""
    why = capitalized(row.why)
    return f"{why}; auto is {auto.value}: {auto.why}." if row.overridden else f"{why}."


_WINDOW = 120
_SMALLEST_MS = 0.005
"""Cost below which two digits are meaningless [ms]; a measured difference may even be negative."""
_STAGES = {"skin": "touch"}
"""Stages with another name than their effect."""
_LIVE = "Median of the last {count} ticks, as it runs now"
_MEASURED_OFFLINE = "Measured by ablation in a separate process"


@dataclass(frozen=True)
class CostText:
    """Cost as text.

    Attributes:
        words: Milliseconds per tick.
        ablation: Whether the cost was measured by ablation in a separate process, not in the running session.
        tip: Tool tip.
    """

    words: str
    ablation: bool
    tip: str


class EffectCosts:
    """Times of the stages. Mutable: ``add`` ticks, set ``prices``.

    Attributes:
        prices: Milliseconds per tick by key of an effect, for effects that are not a stage.
    """

    def __init__(self) -> None:
        self.prices: Mapping[str, float] = {}
        self.clear(0.0)

    def clear(self, tick: float) -> None:
        """Forget all times; ``tick`` is that of the new scene [s]."""
        self._tick = tick
        self.prices = {}
        self._stages: dict[str, deque[float]] = {}
        self._totals: deque[float] = deque(maxlen=_WINDOW)

    def add(self, timings: Timings) -> None:
        """Add the stage times of a tick."""
        for stage, milliseconds in timings.ms.items():
            self._stages.setdefault(stage, deque(maxlen=_WINDOW)).append(milliseconds)
        for stage in [stage for stage in self._stages if stage not in timings.ms]:
            del self._stages[stage]  # switched off: its times are outdated
        self._totals.append(timings.total_ms)

    def of(self, row: EffectRow) -> CostText:
        """Return the current cost of an effect."""
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
        """Total time of a tick and the time available in real time; empty before the first tick."""
        if not self._totals:
            return ""
        return f"{float(np.median(self._totals)):.2f} of {1e3 * self._tick:g}\u202fms a tick"


def _format_ms(milliseconds: float) -> str:
    return f"<{2 * _SMALLEST_MS:.2f}" if milliseconds < _SMALLEST_MS else f"{milliseconds:.2f}"


_CHOICE_PX = 110
_CHOICE_HIGH_PX = 23
_COST_PX = 44
_SCROLL_PX = 16
_MARK = "●"
_DOT_PX = 8


class EffectRowWidget(QWidget):
    """A row: a dot for an overridden effect, the name, a box to choose from, and milliseconds per tick.

    Args:
        key: Key of the effect.
        choices: Choices, ``auto`` first.
        parent: Qt parent.
    """

    chosen = Signal(str, object)
    """Key and override chosen by the user."""
    selected = Signal(str)
    """Key of the row that the user clicked or moved the focus to."""

    def __init__(self, key: str, choices: EffectChoices, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.key = key
        self._index = 0
        self._shown: tuple[EffectRow, EffectRow] | None = None
        self._title = ""
        self.setObjectName(f"effect-{key}")
        dot = small_font(self.font(), _DOT_PX)
        self._mark = make(QLabel, self, foregroundRole=QPalette.ColorRole.Link, fixedWidth=12, font=dot)
        self._name = QLabel(self)
        self._name.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self._why = make(QLabel, self, role="caption", wordWrap=True, minimumWidth=1)
        self._why.hide()
        self.box = make(FlatComboBox, self, objectName=f"effect-{key}-choice", activated=self._on_activated)
        add_items(self.box, ((words, override, "") for words, override in choices))
        self.box.setFixedSize(_CHOICE_PX, _CHOICE_HIGH_PX)
        self.box.installEventFilter(self)
        self._cost = value_label("–", self, right=True, fixedWidth=_COST_PX, objectName=f"effect-{key}-cost")
        grid = make(QGridLayout, self, horizontalSpacing=0, verticalSpacing=2)
        grid.setContentsMargins(0, 0, 0, 0)
        for place, widget in enumerate((self._mark, self._name, self.box, self._cost)):
            grid.addWidget(widget, 0, place)
        grid.addWidget(self._why, 1, 1, 1, 3)
        grid.setColumnStretch(1, 1)

    @property
    def words(self) -> tuple[str, str, str]:
        """Name, value and cost as shown."""
        return self._title, self.box.words, self._cost.text()

    @property
    def marked(self) -> bool:
        """Whether it is marked as overridden."""
        return bool(self._mark.text())

    @property
    def why(self) -> str:
        """Reason as shown; empty while the row is not selected."""
        return "" if self._why.isHidden() else self._why.text()

    def show_row(self, effect: EffectRow, auto: EffectRow) -> None:
        """Show the current state of the effect; ``auto`` is its state without an override."""
        if (effect, auto) == self._shown and self.box.currentIndex() == self._index:
            return
        self._shown = (effect, auto)
        self._title = effect.title
        self._elide()
        self._index = self.box.findText(effect.value) if effect.overridden else 0
        self.box.setItemText(0, f"Auto ({auto.value})")
        self.box.setCurrentIndex(self._index)
        self.box.view().setMinimumWidth(self.box.view().sizeHintForColumn(0) + _SCROLL_PX)
        self.box.say(effect.value, quiet=not effect.on)
        self.box.setAccessibleName(effect.title)
        self._mark.setText(_MARK if effect.overridden else "")
        self._why.setText(effect_reason(effect, auto))
        for widget in (self, self._name, self.box):
            widget.setToolTip(effect_tip(effect, auto))

    def show_cost(self, cost: CostText) -> None:
        """Show the cost; in a quiet colour if it was measured in a separate process."""
        role = QPalette.ColorRole.PlaceholderText if cost.ablation else QPalette.ColorRole.WindowText
        self._cost.setText(cost.words)
        self._cost.setForegroundRole(role)
        self._cost.setToolTip(cost.tip)

    def select(self, *, selected: bool) -> None:
        """Show or hide the reason."""
        self._why.setVisible(selected)

    def _on_activated(self, index: int) -> None:
        self.box.setCurrentIndex(self._index)  # the box shows the current state until that has changed
        if index != self._index:
            self.chosen.emit(self.key, self.box.itemData(index))

    def _elide(self) -> None:
        name = self._name
        name.setText(name.fontMetrics().elidedText(self._title, Qt.TextElideMode.ElideRight, name.width()))

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Select the row when its box gets the keyboard focus."""
        if event.type() == QEvent.Type.FocusIn and isinstance(event, QFocusEvent):
            self.selected.emit(self.key)
        return super().eventFilter(watched, event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self.selected.emit(self.key)
        event.accept()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._elide()


_REFRESH_EVERY = 15
_WARNING = "⚠"
_IN_RECORDING = "Effects used in the recording."


class EffectsPanel(Panel):
    """Effects in rows: state, milliseconds per tick, and a box that overrides each of them."""

    override_requested = Signal(str, object)
    """Key and override chosen by the user; ``auto`` for no override."""
    auto_all_requested = Signal()
    """The user removes all overrides."""

    simulates = True

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Effects", "effects-panel", parent)
        self._empty = self.caption("Open a scene to see its simulated effects.")
        self._costs = EffectCosts()
        self._decision: EffectDecision | None = None
        self.lines: dict[str, EffectRowWidget] = {}
        self._listed = 0.0
        self._count = 0
        self._editable = True
        self._since_shown: dict[tuple[ContactNoteKind, tuple[str, ...]], ContactNote] = {}
        self._content = content = QWidget(self)
        self.column.addWidget(content)
        self._warnings = self._note("effects-warnings")
        self._recorded = make(self._note, "effects-closed", role="caption", text=_IN_RECORDING)
        heads = [make(QLabel, words, content, role="caption") for words in ("Effect", "ms per tick")]
        header = row_layout(*heads)
        header.setAlignment(heads[1], Qt.AlignmentFlag.AlignRight)
        self._body = QWidget(content)
        self._sensor = QWidget(content)
        self._columns = [column_layout(parent=group, spacing=2) for group in (self._body, self._sensor)]
        self._fold = make(
            CollapsibleHeading, "Sensor", content, objectName="effects-sensor-heading", toggled=self._sensor.setHidden
        )
        self._fold.setChecked(True)
        self._total = value_label("", content, right=True, objectName="effects-total")
        tip = "Set every effect to what the scene needs"
        self._auto = push_button(content, "effects-all-auto", "Reset all to auto", tip, self.auto_all_requested)
        self._notes = make(self._note, "effects-notes", role="caption")
        rows = column_layout(self._warnings, self._recorded, header, self._body, parent=content, spacing=2)
        rows.addSpacing(6)
        for widget in (self._fold, self._sensor):
            rows.addWidget(widget)
        rows.addSpacing(8)
        rows.addLayout(row_layout(self._auto, self._total, stretch=self._total))
        rows.addWidget(self._notes)
        content.hide()

    def show_prepared(self, prepared: PreparedScene) -> None:
        """List the effects of another scene."""
        self._empty.hide()
        self._content.show()
        self._costs.clear(prepared.scene.tick)
        if prepared.scene.tick != self._listed:
            self._list_effects(prepared.scene.tick)
        self.show_decision(prepared.scene.decision, automatic_rows(prepared.scene))

    def _list_effects(self, tick: float) -> None:
        """Construct a row for each effect; the choices depend on the tick [s]. Cost: 60 ms."""
        self._listed = tick
        for line in self.lines.values():
            line.hide()  # it is deleted later, and would overlap its successor until then
            line.deleteLater()
        self.lines = {}
        before: list[QWidget] = [self.help, self._fold]
        for key in EFFECTS:
            group = int(EFFECTS[key].of_sensor)
            parent = self._sensor if group else self._body
            line = EffectRowWidget(key, effect_choices(key, tick=tick), parent)
            line.chosen.connect(self.override_requested)
            line.selected.connect(self._on_selected)
            self._columns[group].addWidget(line)
            self.lines[key] = line
            QWidget.setTabOrder(before[group], line.box)  # the rows are constructed after the widgets below them
            before[group] = line.box

    def show_decision(
        self, decision: EffectDecision, autos: Mapping[str, EffectRow], *, notes: Sequence[Finding] = ()
    ) -> None:
        """Show the simulated effects and warnings.

        Args:
            decision: The simulated effects.
            autos: Each effect without its override, by key.
            notes: Warnings in addition to those of the decision.
        """
        self._decision = decision
        for effect in decision.rows:
            self.lines[effect.name].show_row(effect, autos[effect.name])
        self.set_editable(editable=self._editable)
        warnings = [f"{_WARNING} {finding.action}." for finding in (*decision.warnings, *notes)]
        show_text(self._warnings, "\n".join(warnings))
        self.refresh()

    def show_prices(self, prices: dict[str, float]) -> None:
        """Take milliseconds per tick by key, measured in a separate process."""
        self._costs.prices = prices
        self.refresh()

    def show_frame(self, frame: Frame) -> None:
        """Take the stage times and notes of a frame; texts change a few times per second, so that they can be read."""
        self._costs.add(frame.timings)
        self._count += 1
        for note in frame.notes:  # a note may last one tick only
            self._since_shown[note.kind, note.bodies] = note
        if self._count % _REFRESH_EVERY == 1 and self.isVisible():
            self.refresh()
            show_text(self._notes, "\n".join(map(contact_note_text, self._since_shown.values())))
            self._since_shown.clear()

    def set_editable(self, *, editable: bool) -> None:
        self._editable = editable
        self._recorded.setVisible(not editable)
        for line in self.lines.values():
            line.box.setEnabled(editable)
        rows = () if self._decision is None else self._decision.rows
        self._auto.setEnabled(editable and any(effect.overridden for effect in rows))

    def show_reason(self, text: str) -> None:
        self._recorded.setText(text or _IN_RECORDING)

    def refresh(self) -> None:
        """Show the current costs."""
        if self._decision is None:
            return
        for effect in self._decision.rows:
            self.lines[effect.name].show_cost(self._costs.of(effect))
        self._total.setText(self._costs.total)
        on = sum(effect.on for effect in self._decision.rows if EFFECTS[effect.name].of_sensor)
        self._fold.setText(f"Sensor  ·  {on} on" if on else "Sensor  ·  ideal")

    def _note(self, name: str) -> QLabel:
        label = make(QLabel, self._content, objectName=name, wordWrap=True, minimumWidth=1)
        label.hide()
        return label

    def _on_selected(self, key: str) -> None:
        for name, line in self.lines.items():
            line.select(selected=name == key)
