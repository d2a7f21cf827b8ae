"""Settings, effects, behaviours and reading in force in what is shown, told once a change; and those asked for last."""

from __future__ import annotations

from app.control.command import ControlChanged
from app.session.inputs import SessionInput
from app.session.runtime_settings import RuntimeSettings
from app.session.session import Session
from widgets.session.session_signals import SessionSignals


class ActiveSettings:
    """Tells ``facts`` of settings, effects and behaviours, each only when it is another one. Mutable.

    Args:
        facts: Whose signals tell.

    Attributes:
        asked: What the live session was asked for, whether it has taken effect yet or not; None before there is one.
    """

    def __init__(self, facts: SessionSignals) -> None:
        self._facts = facts
        self._told: RuntimeSettings | None = None
        self.asked: RuntimeSettings | None = None
        self._inputs: list[tuple[int, SessionInput]] = []
        self._seen = 0

    def begin(self, session: Session) -> None:
        """Another live session, or one that refused: all is as it has it."""
        self.asked = session.runtime_settings
        self.tell(self.asked)

    def ask(self, act: SessionInput) -> None:
        """The live session was asked for this."""
        if self.asked is not None:
            self.asked = self.asked.after(act)
            self.tell(self.asked)

    def behaved(self, session: Session) -> ControlChanged | None:
        """What a behaviour has made of the controller since the last question, if that is still in force."""
        if session.inputs is not self._inputs:  # it started again
            self._inputs, self._seen = session.inputs, 0
        new, self._seen = session.inputs[self._seen :], len(session.inputs)
        acts = [act for _tick, act in new if isinstance(act, ControlChanged)]
        return acts[-1] if acts and acts[-1].by else None

    def waiting(self, session: Session) -> list[SessionInput]:
        """What was asked of the live session and has not taken effect in it yet, as in one that is paused."""
        if self.asked is None:
            return []
        return self.asked.since(session.runtime_settings)

    def forget(self) -> None:
        """Something else is shown: what is in force there is told even where it is the same."""
        self._told = None

    def tell(self, rules: RuntimeSettings) -> None:
        """These are in force in what is shown."""
        told, self._told = self._told, rules
        if told is None or rules.settings != told.settings:
            self._facts.settings_changed.emit(rules.settings)
        if told is None or rules.effects != told.effects:
            self._facts.effects_changed.emit(rules.effects)
        if told is None or rules.behaviours != told.behaviours:
            self._facts.behaviours_changed.emit(rules.behaviours)
        if told is None or rules.reading != told.reading:
            self._facts.reading_changed.emit(rules.reading)
