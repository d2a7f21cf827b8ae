"""A process beside the window that runs several laws on the same stimulus."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import QObject, Signal

from app.errors import TactileMapsError
from app.session.side_by_side import Contender, side_by_side
from widgets.law_comparison.occasion import Occasion
from widgets.process import Process, Serve, Tell

_DIED = "Comparing ended unexpectedly; what was compared before is kept. Run it again, for fewer seconds."


@dataclass(frozen=True, eq=False)
class Match:
    """Who is compared on what, for how long, and whose task they do; see ``side_by_side``."""

    occasion: Occasion
    contenders: tuple[Contender, ...]
    seconds: float
    own_task: bool


def make_serve() -> Serve:
    """In the process: matches in; progress and traces out."""

    def serve(request: Any, tell: Tell) -> None:
        match: Match = request
        traces = side_by_side(
            match.occasion.prepared,
            match.contenders,
            inputs=match.occasion.inputs,
            seconds=match.seconds,
            own_task=match.own_task,
            progress=lambda *how: tell("progress", how),
        )
        tell("compared", traces)

    return serve


class Comparer(QObject):
    """Runs one match at a time, in a process of its own, so that nothing of the window disturbs its clock."""

    progressed = Signal(str, float)
    """How far it is: seconds in words, and 0 to 1."""
    compared = Signal(tuple)
    """A LawTrace of each contender."""
    failed = Signal(str)
    """Why there are none."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.process = Process("compare laws", make_serve, self)
        self.process.answered.connect(self._on_answered)
        self.process.ended.connect(self._on_ended)

    @property
    def busy(self) -> bool:
        """Whether laws are being run."""
        return bool(self.process.waiting)

    def run(self, match: Match) -> None:
        """Run these laws; what was being run is dropped."""
        self.close()
        self.progressed.emit("starting", 0.0)
        self.process.send(match)

    def close(self) -> None:
        """End the process, whatever it does."""
        self.process.close()

    def _on_answered(self, kind: str, content: Any) -> None:
        if kind == "progress":
            self.progressed.emit(*content)
        elif kind in ("compared", "failed"):
            self.close()
            (self.compared if kind == "compared" else self.failed).emit(content)

    def _on_ended(self) -> None:
        self.close()
        self.failed.emit(_DIED)


class InlineComparer(Comparer):
    """Runs them at once, while the caller waits: deterministic, for tests and pictures."""

    def run(self, match: Match) -> None:
        """Run these laws now."""
        try:
            make_serve()(match, self._on_answered)
        except TactileMapsError as error:
            self.failed.emit(str(error))
