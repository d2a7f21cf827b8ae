"""The tour: five steps to try in the window itself. It waits for each step, blocks nothing, and Escape ends it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPoint, QRect, Qt, QTimer, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QApplication, QLabel, QMainWindow, QWidget

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.arrays import FloatArray
from tactile_widgets.actions.registry import key_text
from tactile_widgets.common.colours import Theme, mixed
from tactile_widgets.common.make import STYLE_SPACING, column_layout, make, push_button, row_layout
from tactile_widgets.common.settings import NavigationStyle
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.jobs.later import call_later
from tactile_widgets.panels.control.controller_panel import ControllerPanel

_WIDTH = 380
_EDGE = 12
_TURNED = 0.02
"""Smallest change of the viewing direction (a unit vector) that counts as turning the view."""
_TURNING = {NavigationStyle.STANDARD: "right", NavigationStyle.MUJOCO: "", NavigationStyle.BLENDER: "middle"}
"""Mouse button that turns the view from any place in it, if there is one."""
_NEXT_MS = 900
"""Time for which a completed step is marked before the next one begins [ms]."""


@dataclass(frozen=True)
class TourStep:
    """A step of the tour.

    Attributes:
        title: Title of the step.
        text: Returns the instruction, with the current keys.
        where: Returns the widget to which the step refers.
        begin: Prepares the detection of its completion.
    """

    title: str
    text: Callable[[], str]
    where: Callable[[], QWidget]
    begin: Callable[[], None]


class _Frame(QWidget):
    """Outline of the widget to which a step refers; transparent to the mouse."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("tour-frame")
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.hide()


class _Card(QWidget):
    """The instruction of a step, with buttons for the next step and the end of the tour."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("tour-card")
        self.setAccessibleName("Tour")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.title = make(QLabel, self, objectName="tour-title", role="heading")
        self.text = make(QLabel, self, objectName="tour-text", wordWrap=True)
        by_tab = Qt.FocusPolicy.TabFocus  # after a click, the views keep the keyboard
        tip = "Continue without this step"
        self.skip = push_button(self, "tour-skip", "Skip", tip, focusPolicy=by_tab)
        tip = "End the tour (Escape)"
        self.leave = push_button(self, "tour-leave", "Leave", tip, focusPolicy=by_tab)
        buttons = row_layout(None, self.skip, self.leave, spacing=STYLE_SPACING)
        parts = (self.title, self.text, buttons)
        column_layout(*parts, parent=self, spacing=STYLE_SPACING, margins=(12, 8, 12, 8))
        self.setFixedWidth(_WIDTH)
        self.hide()


class Tour(QObject):
    """Runs the steps. Mutable: ``start`` begins with the first step, ``leave`` ends the tour.

    Args:
        context: The views, panels and session that the steps use.
        window: Window over which the tour is shown.
        show_panels: Shows the panels.
    """

    ended = Signal()
    """The tour was completed or left."""

    def __init__(self, context: AppContext, window: QMainWindow, show_panels: Callable[[], None]) -> None:
        super().__init__(window)
        self._context = context
        self._window = window
        self._show_panels = show_panels
        self.card = _Card(window)
        self._frame = _Frame(window)
        self._controllers_panel = context.panels.get(ControllerPanel)
        self._steps = self._make_steps()
        self._at: int | None = None
        self._direction: FloatArray | None = None
        self._controller = ""
        self._position = 0
        self._moved = self._chosen = False
        self._waiting = make(QTimer, self, singleShot=True)
        self._waiting.timeout.connect(self._next)
        self.card.skip.clicked.connect(self._next)
        self.card.leave.clicked.connect(self.leave)
        self._listen()
        context.theme.changed.connect(self.set_theme)
        self.set_theme(context.theme.theme)

    @property
    def step(self) -> int | None:
        """Number of the current step, from 0; the number of steps at the end; None if the tour is not running."""
        return self._at

    def start(self) -> None:
        """Start the tour, and the session if it is paused."""
        if self._at is None:
            application = QApplication.instance()
            assert application is not None
            application.installEventFilter(self)
        self._context.session.set_paused(paused=False)
        self._begin(0)

    def leave(self) -> None:
        """End the tour at any step."""
        if self._at is None:
            return
        self._at = None
        self._waiting.stop()
        application = QApplication.instance()
        assert application is not None
        application.removeEventFilter(self)
        self.card.hide()
        self._frame.hide()
        self.ended.emit()

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        background = mixed(theme.panel, theme.accent, 0.10)
        line = f"1px solid {theme.accent}; border-radius: 6px"
        self.card.setStyleSheet(f"#tour-card {{ background: {background}; border: {line}; }}")
        self._frame.setStyleSheet(f"#tour-frame {{ border: 2px solid {theme.accent}; border-radius: 4px; }}")

    # The steps.

    def _turning_text(self) -> str:
        button = _TURNING[self._context.views.navigation]
        return f"Drag {f'with the {button} button, or drag ' if button else ''}next to the robot."

    def _make_steps(self) -> tuple[TourStep, ...]:
        robot, map_ = (lambda: self._context.views.robot), (lambda: self._context.views.map)
        return (
            TourStep(
                "Turn the view",
                self._turning_text,
                robot,
                self._look,
            ),
            TourStep(
                "Poke",
                lambda: "Press the robot's skin and hold: the force grows, and the skin shows its pressure.",
                robot,
                self._select_poke,
            ),
            TourStep(
                "The same place on the map",
                lambda: "The map shows the same skin, flat. Press the map: the finger presses the body there.",
                map_,
                self._select_poke,
            ),
            TourStep("Move a patch, and undo", self._arrange_text, map_, self._select_arrange),
            TourStep("Choose a controller", self._controller_text, self._controllers, self._select_controller),
        )

    def _arrange_text(self) -> str:
        if self._moved:
            return f"Now undo it{self._key('undo')}: any step can be undone."
        return f"Drag a patch of the map with the tool Arrange{self._key('arrange')}. The session continues."

    def _controller_text(self) -> str:
        if self._chosen:
            return "Now press the skin and hold: the arm responds according to the controller."
        return "Choose another controller in this panel, such as Hold force."

    def _key(self, name: str) -> str:
        keys = self._context.actions.keys(name)
        return f" ({key_text(keys[0])})" if keys else ""

    def _controllers(self) -> QWidget:
        return self._controllers_panel if not self._chosen else self._context.views.robot

    def _look(self) -> None:
        self._direction = self._line_of_sight()

    def _select_poke(self) -> None:
        self._context.actions["poke"].trigger()

    def _select_arrange(self) -> None:
        history = self._context.editor.history
        self._moved = False
        self._position = 0 if history is None else history.position
        self._context.actions["arrange"].trigger()

    def _select_controller(self) -> None:
        self._chosen = False
        self._select_poke()
        self._show_panels()
        self._context.panels.reveal(self._controllers_panel)

    def _line_of_sight(self) -> FloatArray:
        seen = self._context.views.robot.display.actors.viewpoint
        along = seen.focus - seen.eye
        return np.asarray(along / np.linalg.norm(along))

    # Detect completed steps.

    def _listen(self) -> None:
        context = self._context
        context.views.robot.display.drawn.connect(self._on_drawn)
        context.views.robot.interaction.poke_pressed.connect(self._on_body_poked)
        context.views.map.interaction.poke_pressed.connect(self._on_map_poked)
        context.editor.settled.connect(self._on_settled)
        context.session.settings_changed.connect(self._on_settings_changed)
        context.session.mode_changed.connect(self._on_mode_changed)

    def _on_drawn(self, *_cost: object) -> None:
        if self._at == 0 and self._direction is not None and _apart(self._line_of_sight(), self._direction) > _TURNED:
            self._done()

    def _on_body_poked(self, _at: object) -> None:
        if self._at == 1 or (self._at == 4 and self._chosen):
            self._done()

    def _on_map_poked(self, _at: object) -> None:
        if self._at == 2 or (self._at == 4 and self._chosen):
            self._done()

    def _on_settled(self, _document: object, _name: str) -> None:
        history = self._context.editor.history
        if self._at != 3 or history is None:
            return
        if history.position > self._position:
            self._moved = True
            self._position = history.position
            self._show()
        elif self._moved and history.position < self._position:
            self._done()

    def _on_settings_changed(self, settings: ControlSettings) -> None:
        other = settings.controller != self._controller
        self._controller = settings.controller
        if self._at == 4 and other:
            self._chosen = True
            self._show()

    def _on_mode_changed(self, _mode: object) -> None:
        """End the tour for another scene or a replay, in which its steps may not be possible."""
        if not self._context.session.simulating:
            self.leave()

    def _done(self) -> None:
        if not self._waiting.isActive():
            self.card.title.setText(f"✓  {self.card.title.text()}")
            self._waiting.start(_NEXT_MS)
            self.card.skip.setText("Next")

    # Move between steps.

    def _begin(self, number: int) -> None:
        self._waiting.stop()
        self._at = number
        if number < len(self._steps):
            self._steps[number].begin()
        self._show()

    def _next(self) -> None:
        if self._at is not None:
            if self._at < len(self._steps):
                self._begin(self._at + 1)
            else:
                self.leave()

    def _show(self) -> None:
        if self._at is None:
            return
        last = self._at == len(self._steps)
        self.card.skip.setVisible(not last)
        self.card.skip.setText("Skip")
        self.card.leave.setText("Close" if last else "Leave")
        if last:
            self.card.title.setText("End of the tour")
            keys = self._key("keys")
            self.card.text.setText(
                f"Help > Keys{keys} lists all gestures and keys. Help > Guide describes everything else."
            )
        else:
            step = self._steps[self._at]
            self.card.title.setText(f"{self._at + 1} of {len(self._steps)}  {step.title}")
            self.card.text.setText(step.text())
        self._place()

    def _place(self) -> None:
        """Place the frame around the step's widget and the card below the views, or on their lower edge."""
        if self._at is None:
            return
        views = self._context.views
        last = self._at == len(self._steps)
        around = QRect() if last else self._in_window(self._steps[self._at].where())
        self._frame.setGeometry(around)
        self._frame.setVisible(not around.isEmpty())
        shown = self._in_window(views)
        high = self.card.heightForWidth(_WIDTH)
        left = min((around if not around.isEmpty() else shown).center().x() - _WIDTH // 2, shown.right() - _WIDTH)
        below = shown.bottom() + _EDGE
        top = below if below + high < self._window.height() - _EDGE else shown.bottom() - high - 3 * _EDGE
        self.card.setGeometry(max(left, _EDGE), top, _WIDTH, high)
        self.card.show()
        for widget in (self._frame, self.card):
            widget.raise_()

    def _in_window(self, widget: QWidget) -> QRect:
        """Return the visible part of a widget in the window (panels scroll); empty for a widget in another window."""
        seen = QRect(widget.mapTo(self._window, QPoint(0, 0)), widget.size()) if self._has(widget) else QRect()
        above = widget.parentWidget()
        while above is not None and self._has(above):
            seen &= QRect(above.mapTo(self._window, QPoint(0, 0)), above.size())
            above = above.parentWidget()
        return seen

    def _has(self, widget: QWidget) -> bool:
        return self._window.isAncestorOf(widget) and widget.window() is self._window and widget.isVisible()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Leave at Escape, which keeps its other effects; move the card when the window or the views are resized."""
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.KeyPress:
            if event.key() == Qt.Key.Key_Escape and QApplication.activeModalWidget() is None:
                self.leave()
        elif event.type() == QEvent.Type.Resize and watched in (self._window, self._context.views):
            call_later(self, self._place)
        return False


def _apart(first: FloatArray, second: FloatArray) -> float:
    return float(np.linalg.norm(first - second))
