"""Menu Control: tools for path and target, the contact force, and the choice of controller, task and gains.

``ControlToolsPresenter`` connects the tools that set path, target and force to actions, session and views;
``ControlPresenter`` connects the actions of controllers, tasks and gains to the controller panel, which decides.
"""

from __future__ import annotations

from functools import partial
from typing import get_args

from PySide6.QtWidgets import QWidget

from tactile_maps.control.controller_registry import CONTROLLERS
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.editing.document import MapDocument
from tactile_maps.maps.paths import PathKind
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.controller_settings import SETTING_CHOICES
from tactile_widgets.common.mode import Mode
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.panels.control.controller_panel import ControllerPanel
from tactile_widgets.session.session_run import SessionRun
from tactile_widgets.tools.control.control_tool import ForceHandle
from tactile_widgets.tools.registry import Tools


class ControlToolsPresenter(Presenter):
    """Implements the actions for path, target and force.

    Args:
        context: Session, views, panels and services of the window.
        tools: Tools of the views.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, tools: Tools, parent: QWidget) -> None:
        super().__init__(context, parent)
        self.settings_editor = tools.control
        self._tools = tools
        self._run: SessionRun | None = None
        self._offered = False
        self._force = ForceHandle(tools.control)
        live = context.session
        editor = self.settings_editor
        editor.settings_requested.connect(live.set_settings)
        editor.settings_requested.connect(self._offer_fixed_object)
        editor.notified.connect(context.notifier.status)
        live.settings_changed.connect(editor.show_settings)
        live.mode_changed.connect(self._on_mode_changed)
        live.prepared_changed.connect(self._on_prepared_changed)
        context.editor.shown.connect(self._on_shown)
        context.actions.bind(
            clear_path=editor.clear_path,
            more_force=partial(self._force.turn, 1),
            less_force=partial(self._force.turn, -1),
        )
        for kind in get_args(PathKind):
            context.actions.bind(**{f"path_{kind}": partial(self._choose_shape, kind)})

    def _offer_fixed_object(self, settings: ControlSettings) -> None:
        """Point out, once per scene, that a path needs a fixed object on the skin, which a mouse finger is not."""
        prepared = self._session.prepared
        if prepared is None or not settings.path or settings.task != "follow_path" or self._offered:
            return
        self._offered = True
        if not prepared.scene.objects:
            text = "The path is followed while an object presses the skin. A mouse finger moves with the skin."
            remedy = self._context.actions["open_path_scene"]
            self._notifier.say(f"{text} Another scene has a fixed knob:", remedies=[remedy])

    def _on_prepared_changed(self, prepared: PreparedScene) -> None:
        """Forget the steps of the previous session, except after a change of the skin.

        A recording that is shown leaves those of the session behind it.
        """
        if self._session.run is not self._run:
            self._run = self._session.run
            self._offered = False
            if not self._tools.skin_steps.expects(prepared.scene):
                self.settings_editor.forget_steps()

    def _choose_shape(self, kind: PathKind) -> None:
        """Choose the shape of the next and of the current path."""
        self.settings_editor.do(
            "choose the path's shape", controller=self.settings_editor.settings.controller, path_kind=kind
        )

    def _on_mode_changed(self, mode: Mode) -> None:
        self.settings_editor.set_enabled(enabled=mode.takes_input)

    def _on_shown(self, document: MapDocument) -> None:
        if not self._context.editor.gesture:
            self.settings_editor.show_map(document.map)


class ControlPresenter(Presenter):
    """Connects the actions of controllers, tasks and gains to the controller panel, which changes the settings.

    Args:
        context: Session, views, panels and services of the window.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        panel = context.panels.get(ControllerPanel)
        for controller in CONTROLLERS:
            context.actions.bind(**{f"controller_{controller}": partial(panel.choose_controller, controller)})
        for task in SETTING_CHOICES["task"][1]:
            context.actions.bind(**{f"task_{task}": partial(panel.choose_task, task)})
        context.actions.bind(start_again=panel.start_again, reset_gains=panel.reset_gains)
