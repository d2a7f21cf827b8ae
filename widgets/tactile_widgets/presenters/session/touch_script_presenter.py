"""Touch menu: save pokes as a script, play a script, repeat recorded touches, and weigh a known load."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from PySide6.QtWidgets import QWidget

from tactile_maps.control.controller_registry import scene_values
from tactile_maps.core.errors import counted
from tactile_maps.simulation.known_load_check import WeighingResult
from tactile_maps.stimuli.stimuli_from_pokes import stimuli_from_pokes
from tactile_maps.stimuli.stimulus_file import load_stimuli, save_stimuli
from tactile_widgets.common.file_dialogs import SCRIPT_FILTER
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import JobProgress, Presenter
from tactile_widgets.jobs.measuring_jobs import KNOWN_MASS
from tactile_widgets.presenters.session.effects_presenter import EffectsPresenter


class TouchScriptPresenter(Presenter):
    """Implements the actions of the Touch menu.

    Args:
        context: Session, views, panels and services of the window.
        effects: Scene with the chosen effects.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, effects: EffectsPresenter, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._effects = effects
        context.actions.bind(
            save_script=self.choose_save,
            play_script=self.choose_play,
            script_once=partial(self.play_again, repeat=False),
            script_repeated=partial(self.play_again, repeat=True),
            repeat_touches=self.repeat,
            weigh=self.weigh,
        )
        self._session.measurements.weighing_changed.connect(self._on_weighing_changed)
        self._session.measurements.weighed.connect(self._on_weighed)
        self._progress = JobProgress(self._notifier, self._session.measurements.cancel_weighing)

    def choose_save(self) -> None:
        """Ask for a file, and save the pokes since the reset; report if there are none."""
        if not self._session.touches():
            self._notifier.say("No pokes to save yet: press the skin first.")
            return
        path = self._context.dialogs.save_file("Save script", "touches.toml", SCRIPT_FILTER)
        if path:
            self.save(path)

    def save(self, path: str) -> None:
        """Save the pokes since the reset as a script."""
        with self._notifier.errors_shown("save script"):
            stimuli = self._session.touches()
            save_stimuli(stimuli, path)
            self._notifier.say(f"Saved {counted(len(stimuli), 'touch')} to {path}")

    def choose_play(self) -> None:
        """Ask for a script."""
        path = self._context.dialogs.open_file("Play script", SCRIPT_FILTER)
        if path:
            self.play(path)

    def play(self, path: str) -> None:
        """Restart the scene with its current settings and play a script."""
        with self._notifier.errors_shown("play script"):
            self._restart(stimuli=load_stimuli(path))
            self._context.dialogs.remember_opened(path)

    def play_again(self, *, repeat: bool) -> None:
        """Restart the scene with its current settings and play its script, once or repeatedly."""
        self._restart(repeat_stimuli=repeat)

    def _restart(self, **changed: Any) -> None:
        run = self._session.run
        scene = self._effects.scene
        if run is not None and scene is not None:
            prepared = replace(run.prepared, scene=replace(scene, **changed))
            self._session.show_prepared(prepared, run.settings)

    def repeat(self) -> None:
        """Restart the scene behind the recording, with its skin, map and controller, and repeat the touches."""
        player = self._session.replay.player
        if player is None:
            return
        tick = player.prepared.scene.tick
        last = round(float(player.times[-1]) / player.prepared.scene.tick)
        stimuli = stimuli_from_pokes(player.prepared.skin, player.inputs, tick=tick, last=last, scripted=True)
        if not stimuli:
            self._notifier.say("This recording contains no touches.")
            return
        if (run := self._session.run) is None:
            return
        control = scene_values(run.settings.settings)
        chosen = self._effects.with_effects(run.prepared, run.settings.effects)
        scene = replace(chosen, stimuli=stimuli, control=control)
        settings = replace(run.settings, effects=scene.effects)
        self._session.show_prepared(replace(run.prepared, scene=scene, map=run.settings.map), settings)
        self._notifier.say("The touches of the recording are repeated here. Record them to compare both.")

    def weigh(self) -> None:
        """Simulate a known load on a copy of the scene in the background, and report its reading."""
        prepared = self._session.prepared
        scene = self._effects.scene
        if prepared is not None and scene is not None:
            self._session.measurements.weigh(prepared, scene.effects)

    def _on_weighing_changed(self, weighing: bool) -> None:
        if weighing:
            self._progress.show(f"Known-load check with {KNOWN_MASS:g} kg")
        else:
            self._progress.end()

    def _on_weighed(self, weighed: WeighingResult) -> None:
        self._notifier.say(
            f"{KNOWN_MASS:g}\u202fkg reads {weighed.read_N:.3f}\u202fN (expected {weighed.expected_N:.3f}\u202fN), "
            f"with {weighed.model} on {weighed.patch}"
        )
