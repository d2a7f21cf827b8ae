"""Dead, stuck, saturated and blind taxels: marked in the views and named in the contacts panel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtWidgets import QWidget

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.scene.effects import Effects
from tactile_maps.session.frame import Frame
from tactile_maps.session.inputs import CalibrationUsed
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.tactile.sensors.sensor_effects import ALIVE, DEAD, STUCK
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.overlays.taxel_faults import TaxelFaults, faults_of
from tactile_widgets.panels.touch.contacts_panel import ContactsPanel


class FaultsPresenter(Presenter):
    """Finds the faults of taxels: in simulation from the effects of the sensor, of a real skin from its channels.

    Args:
        context: Session, views, panels and services of the window.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._prepared: PreparedScene | None = None
        self._effects = Effects()
        self._reading = ReadingSettings()
        self._measured: NDArray[np.int8] | None = None
        live = self._session
        live.prepared_changed.connect(self._on_prepared_changed)
        live.effects_changed.connect(self._on_effects_changed)
        live.reading_changed.connect(self._on_reading_changed)
        live.frame_ready.connect(self._on_frame_ready)

    def _on_prepared_changed(self, prepared: PreparedScene) -> None:
        self._prepared = prepared
        self._measured = None
        self._effects = prepared.scene.effects
        self._show()

    def _on_effects_changed(self, effects: Effects) -> None:
        self._effects = effects
        self._show()

    def _on_reading_changed(self, settings: ReadingSettings) -> None:
        self._reading = settings
        self._show()

    def _on_frame_ready(self, frame: Frame) -> None:
        broken = None if frame.measured is None else self._broken_channels(frame)
        before = self._measured
        self._measured = broken
        if (broken is None or before is None) and broken is before:
            return
        if broken is None or before is None or not np.array_equal(broken, before):
            self._show()

    def _broken_channels(self, frame: Frame) -> NDArray[np.int8]:
        """(taxels,) 0 alive, 1 dead, 2 stuck when a real skin sent the frame."""
        broken = np.full(len(frame.pressures), ALIVE, np.int8)
        if (player := self._session.replay.player) is not None:
            used = [one for tick, one in player.inputs if isinstance(one, CalibrationUsed) and tick <= frame.tick]
            if used:
                broken[used[-1].broken] = DEAD
                broken[used[-1].stuck] = STUCK
        elif (live_input := self._session.live_input) is not None:
            broken[live_input.session.broken_taxels] = DEAD
            broken[live_input.session.stuck_taxels] = STUCK
        return broken

    def _show(self) -> None:
        prepared = self._prepared
        if prepared is None:
            return
        faults = faults_of(prepared, self._effects) if self._measured is None else TaxelFaults(self._measured)
        faults = faults.with_areas(prepared.skin, estimated=self._reading.broken_taxels == "estimated")
        self._context.views.set_faults(faults)
        self._context.panels.get(ContactsPanel).show_faults(faults)
