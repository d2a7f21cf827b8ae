"""The window of a comparison: contenders and stimulus at the left, results at the right."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QDialog,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QSplitter,
    QWidget,
)

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.reading_units import THIN
from tactile_maps.studies.controller_comparison import Contender, ControllerTrace
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import (
    caption_label,
    column_layout,
    make,
    progress_bar,
    push_button,
    resize_on_screen,
    row_layout,
    show_text,
)
from tactile_widgets.common.panel import SLIM_SCROLL_BAR
from tactile_widgets.dialogs.controller_comparison.comparison_plots import LETTERS, ComparisonPlots
from tactile_widgets.dialogs.controller_comparison.comparison_setup import NO_STIMULUS, ContenderCard, StimulusChoice
from tactile_widgets.dialogs.controller_comparison.metrics_table import MetricsTable
from tactile_widgets.session.comparison_stimulus import ComparisonStimulus

_LEFT = 330
_LEAST_PLOTS = 260
"""Width that the plots keep next to the table [px]."""
_RUN_TIP = "Run these controllers on this stimulus"
_EMPTY = (
    "Each controller runs from the same initial state on the same stimuli, in a separate process.\n"
    "Choose the controllers and press Run: their traces and metrics are compared here."
)


class ComparisonView(QWidget):
    """Settings and results of a comparison."""

    run_requested = Signal()
    """The user starts the comparison."""
    cancelled = Signal()
    """The user stops the comparison."""
    used = Signal(ControlSettings)
    """Controller and gains of a contender that are to be used in the session."""
    export_requested = Signal()
    """The user exports the traces."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("comparison-board")
        self._theme = theme
        self.cards: list[ContenderCard] = []
        self._titles: dict[str, str] = {}
        self.traces: tuple[ControllerTrace, ...] = ()
        self.stimulus = StimulusChoice(self)
        self.stimulus.changed.connect(self._on_edited)
        self._make_left()
        self._make_right()
        row_layout(self._left, self._right, parent=self, spacing=16, stretch=self._right, margins=(16, 16, 16, 16))
        self.stimulus.occasion_changed.connect(self._update_run)
        self._update_run()
        self.rest()
        self._show_traces()

    @property
    def contenders(self) -> tuple[Contender, ...]:
        """Chosen contenders."""
        return tuple(Contender(card.letter, card.settings) for card in self.cards)

    def begin(self, settings: Sequence[ControlSettings]) -> None:
        """Start with these contenders and no results."""
        while self.cards:
            self._take_out(self.cards[-1])
        for each in settings:
            self._add(each)
        self.traces = ()
        self._show_traces()

    def set_theme(self, theme: Theme) -> None:
        """Use another theme."""
        self._theme = theme
        for card in self.cards:
            card.set_theme(theme)
        self.plots.set_theme(theme)

    def show_progress(self, text: str, fraction: float) -> None:
        """Show the progress of the comparison."""
        self._progress.setValue(round(1000 * fraction))
        self._say(f"Running {len(self.cards)} controllers: {text}…" if text else "Drawing…")
        self._working(True)

    def show_reading(self, fraction: float) -> None:
        """Show the progress of reading a recording."""
        self._progress.setValue(round(1000 * fraction))
        self._say("Reading the recording…")
        self._working(True)

    def show_stimulus(self, stimulus: ComparisonStimulus) -> None:
        """Use the stimulus of a recording."""
        self.rest()
        self.stimulus.take_recording(stimulus)

    def show_compared(self, traces: tuple[ControllerTrace, ...]) -> None:
        """Show results."""
        self.rest()
        self.traces = traces
        self._titles = {card.letter: card.title for card in self.cards}
        ended = [f"▲ {self._titles[t.name]} {t.end_text(space=THIN)}" for t in traces if t.ended]
        self._show_traces()
        self._say("\n".join(ended))

    def drop_results(self) -> None:
        """Show no results, because another scene is shown."""
        self.rest()
        self.traces = ()
        self._show_traces()
        self._say("Results of the previous scene are dropped: run again.")

    def show_failed(self, text: str) -> None:
        """Show an error; previous results stay."""
        self.rest()
        self._say(f"▲ {text}")

    def rest(self) -> None:
        """Show that nothing is running."""
        self._working(False)
        self._say("")

    def _make_left(self) -> None:
        content = QWidget()
        self._cards = column_layout(spacing=12)
        tip = "Add a controller to the comparison"
        self._more = push_button(self, "comparison-more", "Add a controller", tip, self._on_more)
        controllers = make(QLabel, "Controllers", self, role="heading")
        column = column_layout(controllers, self._cards, self._more, parent=content, margins=(0, 0, 8, 0))
        column.addSpacing(8)
        column.addWidget(make(QLabel, "Stimulus", self, role="heading"))
        column.addWidget(self.stimulus)
        column.addSpacing(8)
        column.addLayout(self._run_row())
        self._note = caption_label(self, "comparison-note")
        column.addWidget(self._note)
        column.addStretch(1)
        self._left = QScrollArea(self)
        self._left.setWidget(content)
        self._left.setWidgetResizable(True)
        self._left.setFixedWidth(_LEFT)
        self._left.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._left.verticalScrollBar().setStyleSheet(SLIM_SCROLL_BAR)

    def _run_row(self) -> QHBoxLayout:
        self._run = push_button(self, "comparison-run", "Run", _RUN_TIP, self.run_requested, default=True)
        tip = "Cancel, and keep the results so far"
        self._cancel = push_button(self, "comparison-cancel", "Cancel", tip, self.cancelled)
        self._progress = progress_bar(self)
        row = make(QHBoxLayout, spacing=8)
        row.addWidget(self._run, 1)
        row.addWidget(self._progress, 1)
        row.addWidget(self._cancel)
        return row

    def _make_right(self) -> None:
        self.plots = ComparisonPlots(self._theme, self)
        self.table = MetricsTable(self)
        self._empty = caption_label(self, text=_EMPTY)
        self._empty.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._right = QWidget(self)
        column = column_layout(parent=self._right)
        self._split = QSplitter(self._right)
        self._split.addWidget(self.plots)
        self._split.addWidget(self.table)
        self._split.setStretchFactor(0, 3)
        self._split.setStretchFactor(1, 2)
        self._split.setChildrenCollapsible(False)
        self._split.setHandleWidth(16)
        self._split.setStyleSheet("QSplitter::handle { background: transparent; }")
        column.addWidget(self._empty, 1)
        column.addWidget(self._split, 1)
        tip = "Every tick of every controller, as a table"
        self._export = push_button(self, "comparison-export", "Export CSV…", tip, self.export_requested)
        self._acts = row_layout(None, self._export)
        self._uses: list[QPushButton] = []
        column.addLayout(self._acts)

    def _working(self, on: bool) -> None:
        self._run.setHidden(on)
        self._progress.setVisible(on)
        self._cancel.setVisible(on)

    def _update_run(self) -> None:
        known = self.stimulus.occasion is not None
        self._run.setEnabled(known)
        self._run.setToolTip(_RUN_TIP if known else NO_STIMULUS)

    def _say(self, text: str) -> None:
        show_text(self._note, text)

    def _show_traces(self) -> None:
        traces = self.traces
        self._empty.setVisible(not traces)
        self._split.setVisible(bool(traces))
        self.plots.show_traces(traces)
        self.table.show_traces(traces, [self._titles[trace.name] for trace in traces])
        room = sum(self._split.sizes()) or self._split.width()
        table = min(self.table.sizeHint().width(), room - _LEAST_PLOTS)
        self._split.setSizes([room - table, table])
        self._export.setVisible(bool(traces))
        for button in self._uses:
            self._acts.removeWidget(button)
            button.hide()
            button.deleteLater()
        self._uses = []
        for number, trace in enumerate(traces):
            tip = f"Use {self._titles[trace.name]} with these gains; the task stays"
            chosen = partial(self._on_use, trace.settings)
            use = push_button(self, f"use-{trace.name}", f"Use {trace.name}", tip, chosen)
            self._acts.insertWidget(number, use)
            self._uses.append(use)

    def _add(self, settings: ControlSettings) -> None:
        letter = next(letter for letter in LETTERS if letter not in {card.letter for card in self.cards})
        card = ContenderCard(letter, settings, self._theme, self)
        card.edited.connect(self._on_edited)
        card.removed.connect(self._on_removed)
        place = LETTERS.index(letter)
        self.cards.insert(place, card)
        self._cards.insertWidget(place, card)
        self._count()

    def _take_out(self, card: ContenderCard) -> None:
        self.cards.remove(card)
        self._cards.removeWidget(card)
        card.hide()
        card.deleteLater()
        self._count()

    def _count(self) -> None:
        self._more.setVisible(len(self.cards) < len(LETTERS))
        for card in self.cards:
            card.set_removable(len(self.cards) > 2)

    def _on_more(self) -> None:
        self._add(self.cards[-1].settings)
        self._on_edited()

    def _on_removed(self, letter: str) -> None:
        self._take_out(next(card for card in self.cards if card.letter == letter))
        self._on_edited()

    def _on_edited(self) -> None:
        if self.traces:
            self._say("▲ These results are outdated: run again.")

    def _on_use(self, settings: ControlSettings, _checked: bool = False) -> None:
        self.used.emit(settings)


class ComparisonDialog(QDialog):
    """Separate window for the comparison."""

    def __init__(self, theme: Theme, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("controller-comparison")
        self.setWindowTitle("Compare controllers")
        resize_on_screen(self, max(min(parent.width(), 1320), 1120), 720)
        self.board = ComparisonView(theme, self)
        column_layout(self.board, parent=self)
