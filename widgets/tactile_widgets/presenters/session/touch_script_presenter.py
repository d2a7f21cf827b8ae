"""The Touch menu: what a user did becomes a script, a script becomes touch, and a known load is weighed."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import QObject

from tactile_maps.control.controller_registry import scene_values
from tactile_maps.core.errors import TactileMapsError
from tactile_maps.simulation.known_load_check import WeighingResult
from tactile_maps.stimuli.stimuli_from_pokes import stimuli_from_pokes
from tactile_maps.stimuli.stimulus_file import load_stimuli, save_stimuli
from tactile_widgets.common.file_types import SCRIPT_FILTER
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.jobs.measuring_jobs import KNOWN_MASS
from tactile_widgets.presenters.session.effects_presenter import EffectsPresenter

WEIGHING_JOB = "weighing"
"""Key of the progress of the known load."""


class TouchScriptPresenter(QObject):
    """Connects the Touch menu's actions to what they do.

    Args:
        context: What it works on.
        effects: Knows the scene as it was chosen.
        parent: Qt parent.
    """

    def __init__(self, context: AppContext, effects: EffectsPresenter, parent: QObject) -> None:
        super().__init__(parent)
        self._context = context
        self._live = context.session
        self._effects = effects
        for name, act in (
            ("save_script", self.choose_save),
            ("play_script", self.choose_play),
            ("repeat_touches", self.repeat),
            ("weigh", self.weigh),
        ):
            context.actions.bind(name, act)
        self._live.measurements.weighing_changed.connect(self._on_weighing_changed)
        self._live.measurements.weighed.connect(self._on_weighed)
        context.notifier.cancelled.connect(self._on_cancelled)

    def choose_save(self) -> None:
        """Ask where to keep what the user did since the reset; say so where nothing was done."""
        if not self._live.touches():
            self._context.notifier.say("No pokes to save yet: press the skin first.")
            return
        path = self._context.dialogs.save_file("Save script", "touches.toml", SCRIPT_FILTER)
        if path:
            self.save(path)

    def save(self, path: str) -> None:
        """Keep what the user did since the reset as a script."""
        try:
            stimuli = self._live.touches()
            save_stimuli(stimuli, path)
        except TactileMapsError as error:
            self._context.notifier.fault(str(error))
        else:
            touches = "1 touch" if len(stimuli) == 1 else f"{len(stimuli)} touches"
            self._context.notifier.say(f"Saved {touches} to {path}")

    def choose_play(self) -> None:
        """Ask for a script."""
        path = self._context.dialogs.open_file("Play script", SCRIPT_FILTER)
        if path:
            self.play(path)

    def play(self, path: str) -> None:
        """Restart the scene with its current settings and let a script touch it."""
        run = self._live.run
        scene = self._effects.scene
        if run is None or scene is None:
            return
        try:
            stimuli = load_stimuli(path)
        except TactileMapsError as error:
            self._context.notifier.fault(str(error))
            return
        self._live.show_prepared(replace(run.prepared, scene=replace(scene, stimuli=stimuli)), run.settings)

    def repeat(self) -> None:
        """Restart the scene behind the recording, with its skin, map and controller, touched as in the recording."""
        player = self._live.replay.player
        if player is None:
            return
        tick = player.prepared.scene.tick
        last = round(float(player.times[-1]) / player.prepared.scene.tick)
        stimuli = stimuli_from_pokes(player.prepared.skin, player.inputs, tick=tick, last=last, scripted=True)
        if not stimuli:
            self._context.notifier.say("Nothing touches the skin in this recording.")
            return
        if (run := self._live.run) is None:
            return
        control = scene_values(run.settings.settings)
        scene = replace(self._effects.chosen(run), stimuli=stimuli, control=control)
        self._live.show_prepared(replace(run.prepared, scene=scene, map=run.settings.map))
        self._context.notifier.say("The touches of the recording are repeated here. Record them to compare both.")

    def weigh(self) -> None:
        """Lay a known load on a copy of the scene beside, and say what it reads."""
        prepared = self._live.prepared
        scene = self._effects.scene
        if prepared is not None and scene is not None:
            self._live.measurements.weigh(prepared, scene.effects)

    def _on_weighing_changed(self, weighing: bool) -> None:
        if weighing:
            self._context.notifier.progress(WEIGHING_JOB, f"Known-load check with {KNOWN_MASS:g} kg")
        else:
            self._context.notifier.done(WEIGHING_JOB)

    def _on_cancelled(self, job: str) -> None:
        if job == WEIGHING_JOB:
            self._live.measurements.cancel_weighing()

    def _on_weighed(self, weighed: WeighingResult) -> None:
        self._context.notifier.say(
            f"{KNOWN_MASS:g}\u202fkg reads {weighed.read_N:.3f}\u202fN (wanted {weighed.wanted_N:.3f}\u202fN), "
            f"with {weighed.model} on {weighed.patch}"
        )
