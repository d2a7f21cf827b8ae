"""The posture a person wants, brought to the session: the robot goes there, or is placed there while it is paused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import QObject
from PySide6.QtGui import QGuiApplication

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import RobotError
from tactile_maps.robots.model.robot import Robot
from tactile_maps.session.inputs import PosturePlaced, RestChanged
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.mode import Mode
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.panels.control.posture_panel import PosturePanel
from tactile_widgets.tools.registry import Tools


class PosturePresenter(QObject):
    """Connects panel, tool and actions of the posture to the session.

    Args:
        context: What it works on.
        tools: With the posture that is wanted.
        parent: Qt parent.
    """

    def __init__(self, context: AppContext, tools: Tools, parent: QObject) -> None:
        super().__init__(parent)
        self._context = context
        self.editor = tools.posture
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
        for name, handler in (
            ("scene_posture", self.reset),
            ("copy_posture", self.copy),
            ("paste_posture", self.paste),
            ("undo_posture", editor.undo),
            ("go_there", self.go_there),
        ):
            context.actions.bind(name, handler)

    # The session.

    def _on_prepared_changed(self, prepared: PreparedScene) -> None:
        self.editor.show_prepared(prepared)
        self._on_mode_changed()

    def _on_mode_changed(self, *_changed: object) -> None:
        session = self._context.session
        prepared = session.prepared
        mode = session.mode
        led = session.simulating and prepared is not None and bool(prepared.robot.joints) and not prepared.scene.motion
        self.editor.set_mode(enabled=mode.takes_input and led, placing=mode is Mode.PAUSED)

    def _on_taken_over(self) -> None:
        """Show the target posture of the recording, to which the robot continues."""
        run = self._context.session.run
        if run is not None:
            changes = [one for _, one in run.runner.session.inputs if isinstance(one, RestChanged | PosturePlaced)]
            self.editor.show_target(np.array(changes[-1].posture) if changes else run.prepared.robot.home)

    def _on_requested(self, posture: FloatArray) -> None:
        session = self._context.session
        if not self.editor.placing:
            session.move_robot(posture)
            return
        error = session.place_robot(posture)
        if error is not None:
            self._refused = posture
            self.editor.reject()
            self._context.notifier.say(str(error), fault=True, remedies=[self._context.actions["go_there"]])

    def _on_previewed(self, posture: FloatArray | None) -> None:
        """The robot view alone shows where the robot would be; map, plots and panels stay with what is."""
        shown = self._context.session.shown
        view = self._context.views.robot.display
        if shown is not None:
            view.show_frame(shown if posture is None else replace(shown, posture=posture))

    def go_there(self) -> None:
        """Let the robot move to the posture that it could not be placed in."""
        posture = self._refused
        self._refused = None
        if posture is not None and self.editor.enabled:
            self._context.session.set_paused(paused=False)
            self.editor.do("move there", posture)

    # The actions.

    def reset(self) -> None:
        """The scene's posture."""
        if self.editor.robot is not None:
            self.editor.do("reset the posture", self.editor.robot.home)

    def copy(self) -> None:
        """The posture wanted as text."""
        if self.editor.robot is not None:
            QGuiApplication.clipboard().setText(posture_text(self.editor.robot, self.editor.target))
            self._context.notifier.status("Posture copied")

    def paste(self) -> None:
        """The posture of the clipboard, or why there is none."""
        robot = self.editor.robot
        if robot is None:
            return
        try:
            posture = posture_from(robot, QGuiApplication.clipboard().text(), self.editor.target)
        except RobotError as error:
            self._context.notifier.fault(str(error))
        else:
            self.editor.do("paste a posture", posture)


def posture_text(robot: Robot, posture: FloatArray) -> str:
    """``shoulder = 0.25`` a line [rad, or m], exact, so that it can be pasted into a scene file too."""
    return "\n".join(
        f"{joint.name} = {position!r}" for joint, position in zip(robot.joints, posture.tolist(), strict=True)
    )


def posture_from(robot: Robot, text: str, base: FloatArray) -> FloatArray:
    """(n,) the posture that ``posture_text`` wrote; joints it does not name stay as in ``base``.

    Raises:
        RobotError: It names no joint of the robot, or a value is no number or beyond its joint's limits.
    """
    posture = base.copy()
    numbers = {joint.name: number for number, joint in enumerate(robot.joints)}
    lines = [line.split("=") for line in text.splitlines() if line.strip()]
    if not lines:
        raise RobotError("there is no posture to paste", remedy="Copy one first: a line a joint, name = radians")
    for name, *values in lines:
        number = numbers.get(name.strip().strip('"'))
        if number is None:
            raise RobotError(
                "there is no such joint", value=name.strip()[:60], remedy=f"Choose one of: {', '.join(numbers)}"
            )
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
            "this is no position of the joint", place=joint.name, value=" = ".join(values).strip()[:60], remedy=limits
        )
    return position
