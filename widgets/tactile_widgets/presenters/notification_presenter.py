"""Messages about the session: failures and stops with remedies, saved files, and the first hints."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QWidget

from tactile_maps.robots.files.model_files import PACKAGE_ROOT_OPTION
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.mode import Mode
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.panels.model.findings_panel import MessagesPanel
from tactile_widgets.presenters.touch_presenter import TouchPresenter
from tactile_widgets.session.recording_writer import DiskSpace

_SAVED_MS = 10_000


class NotificationPresenter(Presenter):
    """Shows messages with remedies.

    Args:
        context: Session, views, panels and services of the window.
        touch: Reports touches; after the first one, the hints are hidden.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, touch: TouchPresenter, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._saved: str | None = None
        context.actions.bind(replay_saved=self._replay_saved, show_saved=self._show_saved)
        self._session.failed.connect(self._on_failed)
        self._session.halted.connect(self._on_halted)
        self._session.recording.saved.connect(self._on_saved)
        self._session.recording.disk_filling.connect(self._on_disk_filling)
        self._session.recording.failed.connect(self._on_recording_failed)
        self._session.prepared_changed.connect(self._on_prepared_changed)
        self._session.mode_changed.connect(self._on_mode_changed)
        touch.touched.connect(self._on_hints_read)
        self._notifier.hints_dismissed.connect(self._on_hints_read)
        self._notifier.message_shown.connect(context.panels.get(MessagesPanel).add)

    def _on_halted(self, text: str) -> None:
        """Report a stop; a failure of the physics can be saved and reproduced, an unexpected error cannot."""
        names = ("reset", "save_report") if self._session.recording.can_report else ("reset",)
        self._notifier.say(text, fault=True, remedies=[self._context.actions[name] for name in names], of="run")

    def _on_failed(self, text: str) -> None:
        """Report a failure, with a remedy if a package root may help."""
        remedies = [self._context.actions["package_root"]] if PACKAGE_ROOT_OPTION in text else []
        self._notifier.say(text.replace(f" ({PACKAGE_ROOT_OPTION})", ""), fault=True, remedies=remedies, of="open file")

    def _on_saved(self, path: str) -> None:
        self._saved = path
        remedies = [self._context.actions[name] for name in ("replay_saved", "show_saved")]
        self._notifier.say(f"Saved {path}", remedies=remedies, of="record", lasting=True)
        self._notifier.status(f"Saved {path}", _SAVED_MS)  # a second message may replace the first
        self._context.settings.add_recent(path)

    def _replay_saved(self) -> None:
        if self._saved is not None:
            self._session.open_recording(self._saved)

    def _show_saved(self) -> None:
        if self._saved is not None:
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(Path(self._saved).parent)))

    def _on_disk_filling(self, space: DiskSpace) -> None:
        minutes = space.seconds / 60
        left = f"{minutes:.0f} minutes" if minutes >= 1.5 else f"{space.seconds:.0f} seconds"
        text = f"The disk of {space.folder} will be full in about {left} of recording ({space.free / 1e6:.0f} MB left)."
        text += " Free space, stop the recording, or choose another folder for the next one."
        self._on_recording_failed(text)

    def _on_recording_failed(self, text: str) -> None:
        """Report that a recording is not written; *Preferences* choose another folder."""
        self._notifier.say(text, fault=True, remedies=[self._context.actions["preferences"]], of="record")

    def _on_mode_changed(self, mode: Mode) -> None:
        if mode is Mode.RUNNING:
            self._notifier.succeed("run")

    def _on_prepared_changed(self, prepared: PreparedScene) -> None:
        self._notifier.drop_outdated()
        missing = [finding for finding in prepared.robot.findings if finding.kind == "missing-mesh"]
        if missing:
            files = f"{len(missing)} meshes of the robot are" if len(missing) > 1 else "A mesh of the robot is"
            text = f"{files} missing, first {missing[0].where}: {missing[0].action}."
            self._notifier.say(text, fault=True, remedies=[self._context.actions["package_root"]], of="open file")
        self._notifier.show_hints(shown=not self._context.settings.hints_read)

    def _on_hints_read(self) -> None:
        self._notifier.show_hints(shown=False)
        self._context.settings.hints_read = True
