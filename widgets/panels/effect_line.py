"""One effect in its panel: name, what it is set to, what it costs; when selected, why."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtGui import QFocusEvent, QFont, QMouseEvent, QPalette, QResizeEvent
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QWidget

from app.scene.decide import EffectRow
from widgets.panels.choice_box import ChoiceBox
from widgets.panels.effect_choices import Choices, reason_of, tip_of
from widgets.panels.panel import fact

_CHOICE_PX, _CHOICE_HIGH_PX, _COST_PX, _MARK_PX, _SCROLL_PX = 110, 23, 44, 12, 16
_MARK, _DOT_PX = "●", 8


class EffectLine(QWidget):
    """A row: a dot for what does not follow from the scene, the name, a box to choose from, milliseconds a tick.

    Args:
        key: Of the effect.
        choices: What it may be set to, ``auto`` first.
        parent: Qt parent.
    """

    chosen = Signal(str, object)
    """Key and wish: what a person asked for."""
    selected = Signal(str)
    """The hand or the keys came here."""

    def __init__(self, key: str, choices: Choices, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.key = key
        self._index, self._title = 0, ""
        self.setObjectName(f"effect-{key}")
        self._mark, self._name, self._why = QLabel(self), QLabel(self), QLabel(self)
        self.box, self._cost = ChoiceBox(self), fact("–", self, right=True)
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
        self._index = self.box.findText(row.value) if row.wished else 0
        self.box.setItemText(0, f"Auto ({auto.value})")
        self.box.setCurrentIndex(self._index)
        self.box.view().setMinimumWidth(self.box.view().sizeHintForColumn(0) + _SCROLL_PX)
        self.box.say(row.value, quiet=not row.on)
        self.box.setAccessibleName(row.title)
        self._mark.setText(_MARK if row.wished else "")
        self._why.setText(reason_of(row, auto))
        for widget in (self, self._name, self.box):
            widget.setToolTip(tip_of(row, auto))

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
