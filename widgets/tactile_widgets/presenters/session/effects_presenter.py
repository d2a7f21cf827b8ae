"""Simulated effects: applies the choices of the panel to the running session, with a question if they are unstable."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial, reduce

from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.scene.effects import Effects, Override
from tactile_maps.scene.scene import Scene, with_override
from tactile_maps.scene.stability import stability_warning
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.studies.study.work_precision import Setting
from tactile_maps.tactile.mechanics.half_space_stress import TAIL_SHARE
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.panels.model.accuracy_panel import AccuracyPanel
from tactile_widgets.panels.model.effects_panel import (
    AUTO,
    EffectsPanel,
    automatic_rows,
    credited_decision,
    measured_decision,
    recorded_decision,
)


class EffectsPresenter(Presenter):
    """Connects the Effects panel, the session and the background measurement of costs.

    A choice takes effect at the next tick, and the state of the session is kept. The user must confirm a choice with
    which the physics is known to be unstable.

    Args:
        context: Session, views, panels and services of the window.
        parent: Window over which dialogs open.

    Attributes:
        scene: Current scene with the chosen effects; None before the first scene.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._panel = context.panels.get(EffectsPanel)
        self.scene: Scene | None = None
        self._prepared: PreparedScene | None = None
        self._home: PreparedScene | None = None
        self._chosen: dict[Effects, Scene] = {}  # the opened scene, and the choices of the user
        self._unconfirmed: Scene | None = None
        self._at_rest = False  # whether the map of the scene has been measured, which comes first
        live = self._session
        panel = self._panel
        live.effects_changed.connect(self._on_effects_changed)
        live.measurements.measured.connect(self._on_measured)
        live.measurements.priced.connect(panel.show_prices)
        panel.folded_changed.connect(self._price)
        panel.override_requested.connect(self.choose)
        panel.auto_all_requested.connect(self._on_auto_all_requested)
        context.actions.bind(use_anyway=self._on_use_anyway)
        context.actions.bind(simulate_fingers=partial(self.choose, "fingers", "on"))

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show another scene; chosen effects survive a replay and live input."""
        self._prepared = prepared
        self._unconfirmed = None
        live_input = self._session.live_input
        waits = live_input is not None and live_input.origin is self._home
        if self._session.replay.player is None and prepared is not self._home and not waits:
            self._home = prepared
            self._chosen = {prepared.scene.effects: prepared.scene}
            self._at_rest = False

    def with_effects(self, prepared: PreparedScene, effects: Effects) -> Scene:
        """Return a scene, shown or behind a recording or a real skin, with effects that the user chose in it."""
        own = prepared.scene
        return self._chosen.get(effects, own) if prepared is self._home else own

    def restore(self, overrides: Mapping[str, Override]) -> None:
        """Choose effects again, without the question about unstable ones, which was answered before."""
        if self._prepared is not None:
            self._use(replace(self._prepared.scene, overrides=overrides))

    def _on_effects_changed(self, effects: Effects) -> None:
        """Show effects that were chosen, restored after an error, or recorded."""
        assert self._prepared is not None
        own = self._prepared.scene
        self.scene = own if self._session.replay.player is not None else self._chosen.get(effects, own)
        self._show(effects)
        if self._at_rest:
            self._price()

    def _show(self, effects: Effects) -> None:
        assert self._prepared is not None
        assert self.scene is not None
        scene = self.scene
        unstable = stability_warning(effects, scene.layer, objects=scene.objects)
        notes = () if unstable is None else (unstable,)
        decision = credited_decision(recorded_decision(scene, effects), self._prepared.scene, scene)
        player = self._session.replay.player
        if (self._session.measured_from if player is None else player.measured) is not None:
            decision = measured_decision(decision)
        self._panel.show_decision(decision, automatic_rows(scene), notes=notes)
        values = {"share": TAIL_SHARE} if effects.skin == "half-space" else {}
        step = {"timestep_ms": round(1e3 * effects.timestep, 6)}
        self._context.panels.get(AccuracyPanel).show_present(Setting("touch", effects.skin, values))
        self._context.panels.get(AccuracyPanel).show_present(Setting("simulation", effects.integrator, step))

    # Choices.

    def choose(self, key: str, value: Override) -> None:
        """Choose an effect, ``auto`` for the needs of the scene; those of a recording cannot change."""
        if self.scene is None or self._session.shown_run is None:
            return
        try:
            scene = with_override(self.scene, key, value)
        except TactileMapsError as error:
            self._notifier.fault(str(error), of="change effects")
            return
        found = stability_warning(scene.effects, scene.layer, objects=scene.objects)
        if found is None or found == stability_warning(
            self.scene.effects, self.scene.layer, objects=self.scene.objects
        ):
            self._use(scene)
            return
        self._unconfirmed = scene
        self._notifier.say(
            f"Unsteady: {found.where}. {found.action}.",
            remedies=[self._context.actions["use_anyway"]],
            dismiss="Keep",
            of="change effects",
        )

    def _on_use_anyway(self) -> None:
        scene = self._unconfirmed
        self._unconfirmed = None
        if scene is not None and self._session.replay.player is None:
            self._use(scene)

    def _on_auto_all_requested(self) -> None:
        if self.scene is not None:
            self._use(reduce(lambda scene, key: with_override(scene, key, AUTO), self.scene.overrides, self.scene))

    def _use(self, scene: Scene) -> None:
        """Apply the effects of a scene from the next tick; a change of the reasons alone is only shown."""
        if (run := self._session.shown_run) is None:
            return
        self._notifier.succeed("change effects")
        self._chosen[scene.effects] = scene
        if scene.effects != run.settings.effects:
            self._session.set_effects(scene.effects)
        else:
            self.scene = scene
            self._show(scene.effects)

    # Costs.

    def _on_measured(self) -> None:
        if not self._at_rest:
            self._at_rest = True
            self._price()

    def _price(self) -> None:
        """Measure the cost of the effects in the background while the panel is unfolded."""
        prepared = self._prepared
        scene = self.scene
        if (
            self._session.replay.player is None
            and prepared is not None
            and scene is not None
            and not self._panel.folded
        ):
            self._session.measurements.price(prepared, scene.effects)
