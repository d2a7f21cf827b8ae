"""Panel *Accuracy and time*: shows the current setting of each stage, and applies a setting that was clicked."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtWidgets import QWidget

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.maps.image_atlas import ImageSettings
from tactile_maps.studies.stages.control import stage_setting_of, with_stage_setting
from tactile_maps.studies.stages.registry import edits_map
from tactile_maps.studies.study.work_precision import Setting
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.document.stage_settings import reflatten_for
from tactile_widgets.panels.control.controller_panel import ControllerPanel
from tactile_widgets.panels.model.accuracy_panel import AccuracyPanel
from tactile_widgets.presenters.session.effects_presenter import EffectsPresenter


class AccuracyPresenter(Presenter):
    """Passes settings to the owners of the stages.

    Args:
        context: Session, views, panels and services of the window.
        effects: Changes touch and simulation.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, effects: EffectsPresenter, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._effects = effects
        self._panel = context.panels.get(AccuracyPanel)
        self._routes: dict[str, Callable[[Setting], None]] = {
            "touch": self._use_touch,
            "simulation": self._use_simulation,
            "control": self._use_control,
            "image": self._use_image,
        }
        self._panel.measure_with(context.backends.executor("accuracy", self._panel))
        self._panel.chosen.connect(self._on_chosen)
        context.session.settings_changed.connect(self._on_settings_changed)
        context.session.frames_passed.connect(self._panel.budget.show_frames)
        section = self._panel.reference
        reference = context.session.reference
        section.enabled_changed.connect(reference.set_enabled)  # no lambda: its receiver may be deleted
        reference.compared.connect(section.show_difference)
        reference.behind.connect(section.show_behind)
        reference.failed.connect(section.show_refusal)
        for signal in (context.editor.settled, context.editor.selection_changed):
            signal.connect(self._show_document)
        look = ImageSettings()
        self._panel.show_present(Setting("image", look.interpolation, {"pixels": look.pixels}))

    def close(self) -> None:
        """Cancel the measurement."""
        self._panel.shut()

    def _on_chosen(self, setting: Setting) -> None:
        """Apply the setting of a point of the diagram."""
        if edits_map(setting):
            self._context.editor.ask(lambda document: reflatten_for(document, setting))
        elif setting.stage in self._routes:
            self._routes[setting.stage](setting)
        else:
            self._notifier.status("The contact model belongs to the scene: choose it under Effects, Skin")

    def _use_touch(self, setting: Setting) -> None:
        self._effects.choose("skin", setting.method)

    def _use_simulation(self, setting: Setting) -> None:
        self._effects.choose("integrator", setting.method)
        self._effects.choose("timestep", 1e-3 * float(setting.values["timestep_ms"]))

    def _use_control(self, setting: Setting) -> None:
        settings = self._context.panels.get(ControllerPanel).settings
        self._session.set_settings(with_stage_setting(settings, setting))

    def _use_image(self, setting: Setting) -> None:
        look = ImageSettings(setting.method, int(setting.values["pixels"]))
        self._session.scene_jobs.image = look
        self._context.views.map.set_image(look)
        self._panel.show_present(setting)

    def _on_settings_changed(self, settings: ControlSettings) -> None:
        self._panel.show_present(stage_setting_of(settings))

    def _show_document(self, *_changed: object) -> None:
        self._panel.show_document(self._context.editor.document, self._context.editor.selected)
