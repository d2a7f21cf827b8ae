"""The errors a user may meet: each says which file, where in it, what was found and what to do.

``TactileMapsError`` and its kinds are failures that were foreseen; ``error.at(place=...)`` is one of them as a caller
who knows more about its place tells it. ``Finding`` is something noticed or repaired on the way in, told rather than
hidden. ``did_you_mean`` writes the remedy for a word that is not known: the nearest spelling, and all there are. For
what nobody foresaw, ``describe_unexpected_error`` gives a person one sentence and writes the traceback to a file in the
user's log folder for a developer.
"""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from difflib import get_close_matches
from pathlib import Path

from platformdirs import user_log_path


class TactileMapsError(Exception):
    """A failure with a remedy; its text is one message a user can act on.

    Args:
        problem: What is wrong, as a short sentence without a full stop.
        file: The file it concerns.
        place: Where in the file: a line, an element, a mesh, a row.
        value: The offending value.
        remedy: What the user can do, as a sentence without a full stop.

    Example:
        >>> try:
        ...     tm.load_robot("arn")
        ... except tm.TactileMapsError as error:
        ...     print(error.value, "->", error.remedy)
        arn -> Did you mean arm? Choose one of: arm, two_arms, ur5e, icub, icub_whole, or give the path of a file
    """

    def __init__(
        self,
        problem: str,
        *,
        file: str | Path | None = None,
        place: str | None = None,
        value: object = None,
        remedy: str | None = None,
    ) -> None:
        self.problem = problem
        self.file = file
        self.place = place
        self.value = value
        self.remedy = remedy
        super().__init__(self._message())

    def at(
        self,
        *,
        place: str | None = None,
        file: str | Path | None = None,
        value: object = None,
        remedy: str | None = None,
        problem: str | None = None,
        kind: type[TactileMapsError] | None = None,
    ) -> TactileMapsError:
        """The same error as one who knows more tells it: what is given replaces what it said, the rest stays.

        Args:
            place: Where in the file.
            file: The file.
            value: The offending value.
            remedy: What the user can do.
            problem: What is wrong.
            kind: The kind of error that the caller raises, by default this one's.
        """
        return (kind or type(self))(
            problem or self.problem,
            file=self.file if file is None else file,
            place=self.place if place is None else place,
            value=self.value if value is None else value,
            remedy=remedy or self.remedy,
        )

    def _message(self) -> str:
        where = ", ".join(str(part) for part in (self.file, self.place) if part is not None)
        found = f" (found: {_shorten(self.value)})" if self.value is not None else ""
        remedy = f". {self.remedy}." if self.remedy else "."
        return f"{where}: {self.problem}{found}{remedy}" if where else f"{self.problem}{found}{remedy}"

    def __reduce__(self) -> tuple[object, ...]:
        """Errors cross from the worker process to the window, so they must pickle with their keywords."""
        return (
            _rebuild,
            (
                type(self),
                self.problem,
                str(self.file) if self.file else None,
                self.place,
                None if self.value is None else str(self.value),
                self.remedy,
            ),
        )


def _rebuild(
    kind: type[TactileMapsError],
    problem: str,
    file: str | None,
    place: str | None,
    value: str | None,
    remedy: str | None,
) -> TactileMapsError:
    return kind(problem, file=file, place=place, value=value, remedy=remedy)


def _shorten(value: object, limit: int = 120) -> str:
    text = " ".join(str(value).split())
    return text if len(text) <= limit else text[: limit - 1] + "…"


class UsageError(TactileMapsError):
    """The command was called wrongly; the command line answers with exit code 2."""


class MeshError(TactileMapsError):
    """A mesh that cannot be used."""


class RobotError(TactileMapsError):
    """A robot that cannot be found, read or simulated."""


class SkinError(TactileMapsError):
    """A skin or taxel file that cannot be used."""


class MapError(TactileMapsError):
    """A patch that cannot be flattened, or a map file that cannot be read."""


class SceneError(TactileMapsError):
    """A scene that cannot be read or assembled."""


class SimulationError(TactileMapsError):
    """The physics left the region where its numbers mean something."""


class RecordingError(TactileMapsError):
    """A recording that cannot be written or read."""


class LiveError(TactileMapsError):
    """Readings of a real skin that cannot be received, understood or tied to taxels."""


class ExportError(TactileMapsError):
    """A recording, table or page that cannot be written for other programs, or a live stream that cannot begin."""


class BudgetError(TactileMapsError):
    """A budget of time or error that means nothing, or that no settings keep."""


class LearningError(TactileMapsError):
    """A learning environment that cannot be made, or an action that it refuses."""


class ClusterError(TactileMapsError):
    """A cluster of machines that cannot be reached, or whose workers cannot be used."""


class PluginError(TactileMapsError):
    """A plug-in that cannot be used, or that failed at work."""


class DisplayError(TactileMapsError):
    """There is no display, or it cannot draw."""


@dataclass(frozen=True)
class Finding:
    """Something noticed or repaired on the way in, told to the user rather than hidden.

    Attributes:
        kind: A short stable name, e.g. ``missing-mesh`` or ``duplicate-taxel``.
        where: The file, link or element.
        action: What was done about it, or what the user can do.
        count: How many there were.
    """

    kind: str
    where: str
    action: str
    count: int = 1


def parser_message(error: Exception) -> str:
    """Return what a parser of Python complains about, in words where it names only a limit or a class of its own."""
    if isinstance(error, RecursionError):
        return "lists and objects are nested too deep"
    if str(error).startswith("Exceeds the limit"):  # of digits that Python converts
        return "a whole number has too many digits"
    return str(error)


def did_you_mean(word: str, known: tuple[str, ...]) -> str:
    """A remedy for a word that is not known: the nearest spelling, and all there are."""
    close = get_close_matches(word.lower(), known, n=1, cutoff=0.5)
    every = f"Choose one of: {', '.join(known)}" if known else "There are none"
    return f"Did you mean {close[0]}? {every}" if close else every


def add_finding(findings: list[Finding], kind: str, where: str, action: str, count: int) -> None:
    """Add a finding where there is something to count."""
    if count:
        findings.append(Finding(kind, where, action, count))


@contextmanager
def errors_in_file(file: str | Path) -> Iterator[None]:
    """Errors raised inside that name no file name this one."""
    try:
        yield
    except TactileMapsError as error:
        if error.file is not None:
            raise
        raise error.at(file=file) from error


def write_crash_log(error: BaseException) -> Path:
    """Write the traceback of ``error`` to a new file in the user's log folder; the file is returned."""
    folder = user_log_path("tactile-maps", appauthor=False)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"crash {datetime.now():%Y-%m-%d %H.%M.%S.%f}.txt"
    path.write_text("".join(traceback.format_exception(error)), encoding="utf8")
    return path


def describe_unexpected_error(error: BaseException) -> str:
    """One sentence for a person about a problem nobody foresaw, naming the file with the details."""
    try:
        where = f"The details are in {write_crash_log(error)}"
    except OSError as failure:
        where = f"The details could not be written ({failure.strerror})"
    return f"an unexpected problem: {type(error).__name__}: {error}. {where}"
