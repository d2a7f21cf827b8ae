"""What a person chose to simulate: wishes from the panel act live, and are asked about where they may go wrong."""

from __future__ import annotations

from functools import partial, reduce

from PySide6.QtCore import QObject

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.scene.effects import Effects, Override
from tactile_maps.scene.scene import Scene, with_override
from tactile_maps.scene.stability import stability_warning
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.studies.study.work_precision import Setting
from tactile_maps.tactile.mechanics.half_space_stress import TAIL_SHARE
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.panels.model.accuracy_panel import AccuracyPanel
from tactile_widgets.panels.model.effects_panel import (
    AUTO,
    EffectsPanel,
    automatic_rows,
    credited_decision,
    recorded_decision,
)
from tactile_widgets.session.session_run import SessionRun


class EffectsPresenter(QObject):
    """Connects the Effects panel, the session, and the prices measured beside.

    A wish takes effect at the next tick, and the session's state is kept. One that enters a corner where the physics
    is known to be unstable is asked about first.

    Args:
        context: What it works on.
        parent: Qt parent.

    Attributes:
        scene: What is shown, with every effect as it was chosen; None before there is one.
    """

    def __init__(self, context: AppContext, parent: QObject) -> None:
        super().__init__(parent)
        self._context = context
        self._live = context.session
        self._panel = context.panels.get(EffectsPanel)
        self.scene: Scene | None = None
        self._prepared: PreparedScene | None = None
        self._home: PreparedScene | None = None
        self._chosen: dict[Effects, Scene] = {}  # what was opened, and what a person made of it
        self._asked_about: Scene | None = None
        self._at_rest = False  # the map of the scene is measured; before, whoever looks at it comes first
        live = self._live
        panel = self._panel
        live.effects_changed.connect(self._on_effects_changed)
        live.measurements.measured.connect(self._on_measured)
        live.measurements.priced.connect(panel.show_prices)
        panel.folded_changed.connect(self._price)
        panel.override_requested.connect(self.wish)
        panel.auto_all_requested.connect(self._on_all_auto_wished)
        context.actions.bind("use_anyway", self._on_use_anyway)
        context.actions.bind("simulate_fingers", partial(self.wish, "fingers", "on"))

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show another scene; the effects chosen for one survive a replay and live input."""
        self._prepared = prepared
        self._asked_about = None
        live_input = self._live.live_input
        waits = live_input is not None and live_input.origin is self._home
        if self._live.replay.player is None and prepared is not self._home and not waits:
            self._home = prepared
            self._chosen = {prepared.scene.effects: prepared.scene}
            self._at_rest = False

    def chosen(self, run: SessionRun) -> Scene:
        """The scene that runs, or waits behind a recording, with every effect as it was chosen."""
        own = run.prepared.scene
        return self._chosen.get(run.settings.effects, own) if run.prepared is self._home else own

    def _on_effects_changed(self, effects: Effects) -> None:
        """Asked for, gone back to after a refusal, or passed in a replay."""
        assert self._prepared is not None
        own = self._prepared.scene
        self.scene = own if self._live.replay.player is not None else self._chosen.get(effects, own)
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
        self._panel.show_decision(decision, automatic_rows(scene), notes=notes)
        values = {"share": TAIL_SHARE} if effects.skin == "half-space" else {}
        step = {"timestep_ms": round(1e3 * effects.timestep, 6)}
        self._context.panels.get(AccuracyPanel).show_present(Setting("touch", effects.skin, values))
        self._context.panels.get(AccuracyPanel).show_present(Setting("simulation", effects.integrator, step))

    # Wishes.

    def wish(self, key: str, wish: Override) -> None:
        """Have an effect otherwise; ``auto`` for as the scene needs it."""
        if self.scene is None:
            return
        try:
            scene = with_override(self.scene, key, wish)
        except TactileMapsError as error:
            self._context.notifier.fault(str(error))
            return
        found = stability_warning(scene.effects, scene.layer, objects=scene.objects)
        if found is None or found == stability_warning(
            self.scene.effects, self.scene.layer, objects=self.scene.objects
        ):
            self._use(scene)
            return
        self._asked_about = scene
        self._context.notifier.say(
            f"Unsteady: {found.where}. {found.action}.",
            remedies=[self._context.actions["use_anyway"]],
            dismiss="Keep",
        )

    def _on_use_anyway(self) -> None:
        scene = self._asked_about
        self._asked_about = None
        if scene is not None and self._live.replay.player is None:
            self._use(scene)

    def _on_all_auto_wished(self) -> None:
        if self.scene is not None:
            self._use(reduce(lambda scene, key: with_override(scene, key, AUTO), self.scene.overrides, self.scene))

    def _use(self, scene: Scene) -> None:
        """Simulate so from the next tick on; a wish that changes nothing but the reason is only shown."""
        assert self.scene is not None
        self._chosen[scene.effects] = scene
        if scene.effects != self.scene.effects:
            self._live.set_effects(scene.effects)
        else:
            self.scene = scene
            self._show(scene.effects)

    # Prices.

    def _on_measured(self) -> None:
        if not self._at_rest:
            self._at_rest = True
            self._price()

    def _price(self) -> None:
        """Have what is no stage of its own measured beside, while somebody can see the panel."""
        prepared = self._prepared
        scene = self.scene
        if self._live.replay.player is None and prepared is not None and scene is not None and not self._panel.folded:
            self._live.measurements.price(prepared, scene.effects)
