"""Recorder of the signals that the gestures on a view emit."""

from __future__ import annotations


class Heard:
    """Records the pokes and hovers of a view, and the values of more signals, by name."""

    def __init__(self, view, **signals):
        self.acts = []
        self.hovers = []
        view.interaction.poke_pressed.connect(self._on_pressed)
        view.interaction.poke_moved.connect(self._on_moved)
        view.interaction.poke_released.connect(self._on_released)
        view.interaction.hovered.connect(self.hovers.append)
        for name, signal in signals.items():
            setattr(self, name, [])
            signal.connect(getattr(self, name).append)

    def _on_pressed(self, at):
        self.acts.append(("pressed", at))

    def _on_moved(self, at):
        self.acts.append(("moved", at))

    def _on_released(self):
        self.acts.append(("released", None))

    @property
    def kinds(self):
        return [kind for kind, _ in self.acts]
