"""Settings and effects in force in what is shown, told once a change; and those the live session was asked for last."""

from __future__ import annotations

from dataclasses import dataclass, replace

from app.control.command import ControlChanged, ControlSettings
from app.scene.effects import Effects
from app.session.inputs import EffectsChanged, SessionInput
from app.session.session import Session
from widgets.session_facts import SessionFacts


@dataclass(frozen=True)
class Rules:
    """By what a session runs at one instant."""

    settings: ControlSettings
    effects: Effects

    @classmethod
    def of(cls, session: Session) -> Rules:
        """Those it has now."""
        return cls(session.settings, session.effects)


class InForce:
    """Tells ``facts`` of settings and effects, each only when it is another one. Mutable.

    Args:
        facts: Whose signals tell.

    Attributes:
        asked: What the live session was asked for, whether it has taken effect yet or not; None before there is one.
    """

    def __init__(self, facts: SessionFacts) -> None:
        self._facts = facts
        self._told: Rules | None = None
        self.asked: Rules | None = None

    def begin(self, session: Session) -> None:
        """Another live session, or one that refused: all is as it has it."""
        self.asked = Rules.of(session)
        self.tell(self.asked)

    def ask(self, act: SessionInput) -> None:
        """The live session was asked for this."""
        if self.asked is not None and isinstance(act, ControlChanged | EffectsChanged):
            if isinstance(act, ControlChanged):
                self.asked = replace(self.asked, settings=act.settings)
            else:
                self.asked = replace(self.asked, effects=act.effects)
            self.tell(self.asked)

    def waiting(self, session: Session) -> list[SessionInput]:
        """What was asked of the live session and has not taken effect in it yet, as in one that is paused."""
        acts: list[SessionInput] = []
        if self.asked is not None and self.asked.settings != session.settings:
            acts.append(ControlChanged(self.asked.settings))
        if self.asked is not None and self.asked.effects != session.effects:
            acts.append(EffectsChanged(self.asked.effects))
        return acts

    def forget(self) -> None:
        """Something else is shown: what is in force there is told even where it is the same."""
        self._told = None

    def tell(self, rules: Rules) -> None:
        """These are in force in what is shown."""
        told, self._told = self._told, rules
        if told is None or rules.settings != told.settings:
            self._facts.settings_changed.emit(rules.settings)
        if told is None or rules.effects != told.effects:
            self._facts.effects_changed.emit(rules.effects)
