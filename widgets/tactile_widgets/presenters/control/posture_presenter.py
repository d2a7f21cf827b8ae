"""Target posture of the robot: it moves there, or is placed there while the session is paused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QWidget

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import RobotError
from tactile_maps.robots.model.robot import Robot
from tactile_maps.session.inputs import PosturePlaced, RestChanged
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.mode import Mode
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.panels.control.posture_panel import PosturePanel
from tactile_widgets.tools.registry import Tools


class PosturePresenter(Presenter):
    """Connects panel, tool and actions for the posture to the session.

    Args:
        context: Session, views, panels and services of the window.
        tools: Tools of the views.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, tools: Tools, parent: QWidget) -> None:
        super().__init__(context, parent)
        self.editor = tools.posture
        self._skin_steps = tools.skin_steps
        self._refused: FloatArray | None = None
        session = context.session
        editor = self.editor
        panel = context.panels.get(PosturePanel)
        session.prepared_changed.connect(self._on_prepared_changed)
        session.frame_ready.connect(editor.show_frame)
        session.replay.taken_over.connect(self._on_taken_over)
        for signal in (session.mode_changed, session.connection.changed):
            signal.connect(self._on_mode_changed)
        editor.requested.connect(self._on_requested)
        editor.previewed.connect(self._on_previewed)
        editor.notified.connect(context.notifier.status)
        panel.follow_editor(editor)
        panel.scene_posture_requested.connect(self.reset)
        panel.copied.connect(self.copy)
        panel.pasted.connect(self.paste)
        context.actions.bind(
            scene_posture=self.reset,
            copy_posture=self.copy,
            paste_posture=self.paste,
            undo_posture=editor.undo,
            go_there=self.go_there,
        )

    # The session.

    def _on_prepared_changed(self, prepared: PreparedScene) -> None:
        self.editor.show_prepared(prepared, other_skin=self._skin_steps.expects(prepared.scene))
        self._on_mode_changed()

    def _on_mode_changed(self, *_changed: object) -> None:
        session = self._session
        prepared = session.prepared
        mode = session.mode
        led = session.simulating and prepared is not None and bool(prepared.robot.joints) and not prepared.scene.motion
        self.editor.set_mode(enabled=mode.takes_input and led, placing=mode is Mode.PAUSED)

    def _on_taken_over(self) -> None:
        """Show the target posture of the recording, to which the robot continues."""
        run = self._session.run
        if run is not None:
            changes = [one for _, one in run.runner.session.inputs if isinstance(one, RestChanged | PosturePlaced)]
            self.editor.show_target(np.array(changes[-1].posture) if changes else run.prepared.robot.home)

    def _on_requested(self, posture: FloatArray) -> None:
        session = self._session
        if not self.editor.placing:
            session.move_robot(posture)
            return
        error = session.place_robot(posture)
        if error is None:
            self._notifier.succeed("place robot")
        else:
            self._refused = posture
            self.editor.reject()
            self._notifier.say(str(error), fault=True, remedies=[self._context.actions["go_there"]], of="place robot")

    def _on_previewed(self, posture: FloatArray | None) -> None:
        """Show a preview of the posture in the robot view only; map, plots and panels show the actual one."""
        shown = self._session.shown
        view = self._context.views.robot.display
        if shown is not None:
            view.show_frame(shown if posture is None else replace(shown, posture=posture))

    def go_there(self) -> None:
        """Resume, and let the robot move to the posture in which it could not be placed."""
        posture = self._refused
        self._refused = None
        if posture is not None and self.editor.enabled:
            self._session.set_paused(paused=False)
            self.editor.do("move there", posture)

    # The actions.

    def reset(self) -> None:
        """Return to the home posture of the scene."""
        if self.editor.robot is not None:
            self.editor.do("reset the posture", self.editor.robot.home)

    def copy(self) -> None:
        """Copy the target posture as text."""
        if self.editor.robot is not None:
            QGuiApplication.clipboard().setText(posture_text(self.editor.robot, self.editor.target))
            self._notifier.status("Posture copied")

    def paste(self) -> None:
        """Move to the posture in the clipboard, or report why that is impossible."""
        robot = self.editor.robot
        if robot is None:
            return
        with self._notifier.errors_shown("paste posture"):
            posture = posture_from(robot, QGuiApplication.clipboard().text(), self.editor.target)
            self.editor.do("paste a posture", posture)


def posture_text(robot: Robot, posture: FloatArray) -> str:
    """Return one line ``shoulder = 0.25`` per joint [rad, or m], exact, valid in a scene file too."""
    return "\n".join(
        f"{joint.name} = {position!r}" for joint, position in zip(robot.joints, posture.tolist(), strict=True)
    )


def posture_from(robot: Robot, text: str, base: FloatArray) -> FloatArray:
    """Return the posture (n,) that ``posture_text`` wrote; joints without a line keep their value of ``base``.

    Raises:
        RobotError: An unknown joint, or a value that is not a number within the limits of its joint.
    """
    posture = base.copy()
    numbers = {joint.name: number for number, joint in enumerate(robot.joints)}
    lines = [line.split("=") for line in text.splitlines() if line.strip()]
    if not lines:
        raise RobotError("the clipboard holds no posture", remedy="Copy one first: a line per joint, name = radians")
    for name, *values in lines:
        number = numbers.get(name.strip().strip('"'))
        if number is None:
            raise RobotError("unknown joint", value=name.strip()[:60], remedy=f"Choose one of: {', '.join(numbers)}")
        posture[number] = _position(values, robot, number)
    return posture


def _position(values: list[str], robot: Robot, number: int) -> float:
    joint = robot.joints[number]
    try:
        position = float(values[0]) if len(values) == 1 else np.nan
    except ValueError:
        position = np.nan
    if not joint.lower - 1e-9 <= position <= joint.upper + 1e-9:
        limits = f"Give a number from {joint.lower:.6g} to {joint.upper:.6g}"
        raise RobotError(
            "invalid joint position", place=joint.name, value=" = ".join(values).strip()[:60], remedy=limits
        )
    return position
