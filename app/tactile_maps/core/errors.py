"""Errors that a user may see: each names the file, the place in it, the invalid value and the remedy.

``TactileMapsError`` and its subclasses are expected failures; ``error.at(place=...)`` adds what a caller knows about
the place. A ``Finding`` reports something that was noticed or repaired while reading a file. ``did_you_mean`` writes
the remedy for an unknown word: the nearest spelling, and all known words. For unexpected failures,
``describe_unexpected_error`` gives the user one sentence and writes the traceback to a file in the log folder.
``install_line`` is the remedy for a missing optional package: the command for this environment.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from difflib import get_close_matches
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec
from numbers import Real
from pathlib import Path, PurePath

from platformdirs import user_log_path


class TactileMapsError(Exception):
    """Failure with a remedy; its text is one message for the user.

    Args:
        problem: What is wrong, as a short sentence without a full stop.
        file: The file concerned.
        place: Place in the file: a line, an element, a mesh, a row.
        value: The offending value.
        remedy: What the user can do, as a sentence without a full stop.

    Example:
        >>> try:
        ...     tm.load_robot("arn")
        ... except tm.TactileMapsError as error:
        ...     print(error.value, "->", error.remedy)
        arn -> Did you mean arm? Choose one of: arm, two_arms, ur5e, icub, icub_whole, hand, or give the path of a file
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
        self.value = system_message(value) if isinstance(value, Exception) else value
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
        """Return the same error with some of its parts replaced.

        Args:
            place: Place in the file.
            file: The file.
            value: The offending value.
            remedy: What the user can do.
            problem: What is wrong.
            kind: Class of the new error, by default that of this one.
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
        """Pickle errors with their keywords, because they are passed from worker processes to the window."""
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


_LONGEST_VALUE = 120


def _shorten(value: object) -> str:
    text = " ".join(str(value).split())
    return text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 1] + "…"


def check_names(names: object, place: str, *, error: type[TactileMapsError]) -> None:
    """Reject a single name in place of a sequence of names, whose letters would be read as names.

    Raises:
        TactileMapsError: ``names`` is a string or a path; raised as ``error``.
    """
    if isinstance(names, str | PurePath):
        remedy = f'Write it as a sequence: {place}=("{names}",)'
        raise error("a single name in place of a sequence of names", place=place, value=names, remedy=remedy)


class UsageError(TactileMapsError):
    """Invalid use of a command; the command line returns exit code 2."""


class MeshError(TactileMapsError):
    """Mesh that is not usable."""


class RobotError(TactileMapsError):
    """A robot that cannot be found, read or simulated."""


class SkinError(TactileMapsError):
    """A skin or taxel file that cannot be used."""


class MapError(TactileMapsError):
    """A patch that cannot be flattened, or a map file that cannot be read."""


class SceneError(TactileMapsError):
    """A scene that cannot be read or assembled."""


class SimulationError(TactileMapsError):
    """Simulation whose numbers became meaningless."""


class RecordingError(TactileMapsError):
    """A recording that cannot be written or read."""


class LiveError(TactileMapsError):
    """Readings of a real skin that cannot be received, understood or assigned to taxels."""


class ExportError(TactileMapsError):
    """Recording, table or page that cannot be written for other programs, or a live stream that cannot start."""


class BudgetError(TactileMapsError):
    """Budget of time or error that is invalid or that no settings meet."""


class LearningError(TactileMapsError):
    """Learning environment that cannot be created, or an action that it rejects."""


class ClusterError(TactileMapsError):
    """A cluster of machines that cannot be reached, or whose workers cannot be used."""


class PluginError(TactileMapsError):
    """Plug-in that is invalid or that failed."""


class DisplayError(TactileMapsError):
    """Display that is missing or cannot draw."""


@dataclass(frozen=True)
class Finding:
    """Report of something that was noticed or repaired while reading a file.

    Attributes:
        kind: Short stable name, such as ``missing-mesh`` or ``duplicate-taxel``.
        where: File, link or element.
        action: What was done about it, or what the user can do.
        count: Number of occurrences.
    """

    kind: str
    where: str
    action: str
    count: int = 1


def system_message(error: Exception) -> str:
    """Return the message of an error without the system's number, such as ``[Errno 111]``."""
    return re.sub(r"\[(Errno|WinError) -?\d+\] ", "", str(error))


def parser_message(error: Exception) -> str:
    """Return the message of an error of a Python parser, reworded where it names only an internal limit."""
    if isinstance(error, RecursionError):
        return "lists and objects are nested too deep"
    if str(error).startswith("Exceeds the limit"):  # of digits that Python converts
        return "a whole number has too many digits"
    return str(error)


def did_you_mean(word: str, known: tuple[str, ...]) -> str:
    """Return the remedy for an unknown word: the known word of a similar spelling, if any, and all known words.

    Similar are words with one typing error, and a word of which the other is an abbreviation, as in ``deg``.
    """
    folded = {name.casefold(): name for name in known}
    sought = word.casefold()
    close = get_close_matches(sought, folded, n=1, cutoff=0.65)  # 0.67: one of three letters differs
    close = close or [name for name in folded if len(name) > 2 and sought.startswith(name)]
    every = f"Choose one of: {', '.join(known)}" if known else "There are none"
    return f"Did you mean {folded[close[0]]}? {every}" if close else every


_WITH_ES = ("ch", "sh", "s", "x")
"""Endings of nouns whose plural has another syllable."""


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, in the plural unless the number is 1.

    Args:
        number: The number.
        noun: English noun in the singular with a regular plural, possibly after other words.

    Examples:
        >>> counted(1, "patch"), counted(2, "patch"), counted(0, "damaged copy")
        ('1 patch', '2 patches', '0 damaged copies')
    """
    if number == 1:
        return f"{number} {noun}"
    if noun.endswith(_WITH_ES):
        return f"{number} {noun}es"
    if noun.endswith("y") and noun[-2] not in "aeiou":
        return f"{number} {noun[:-1]}ies"
    return f"{number} {noun}s"


def check_range(
    what: str,
    value: float,
    low: float,
    high: float,
    *,
    error: type[TactileMapsError],
    place: str | None = None,
    unit: str = "",
) -> None:
    """Raise ``error`` unless a value is a number from ``low`` to ``high``; NaN is not.

    Args:
        what: The value in words, such as "the pitch".
        value: The value.
        low: Lowest valid number.
        high: Highest valid number.
        error: Class of the error.
        place: Where the value is stated.
        unit: Unit of the numbers, if they have one.
    """
    number = isinstance(value, Real) and not isinstance(value, bool)
    if number and low <= value <= high:
        return
    found = f"{value:g} {unit}" if unit and number else value
    limits = " to ".join(f"{limit:,}" if isinstance(limit, int) else f"{limit:g}" for limit in (low, high))
    remedy = f"Choose {limits} {unit}".rstrip()
    raise error(f"{what} is out of range", place=place, value=found, remedy=remedy)


def names_text(names: Sequence[str], most: int = 8, *, separator: str = ", ") -> str:
    """Return names as a list in words, at most ``most`` of them written out."""
    more = len(names) - most
    return separator.join(names[:most]) + (f" and {more} more" if more > 0 else "")


def places_finding(
    kind: str, places: Sequence[str], action: str, *, count: int | None = None, separator: str = ", "
) -> list[Finding]:
    """Return one finding for all places, of which the first ones are named; no finding without places.

    Args:
        kind: Kind of the finding.
        places: Places, in order.
        action: What was done about them.
        count: Number of occurrences; by default the number of places.
        separator: Text between two places.
    """
    if not places:
        return []
    named = separator.join(places[:SHOWN_PLACES]) + (", …" if len(places) > SHOWN_PLACES else "")
    return [Finding(kind, named, action, len(places) if count is None else count)]


SHOWN_PLACES = 5
"""Number of places that a finding names."""


def add_finding(findings: list[Finding], kind: str, where: str, action: str, count: int) -> None:
    """Add a finding unless ``count`` is 0."""
    if count:
        findings.append(Finding(kind, where, action, count))


@contextmanager
def errors_in_file(file: str | Path) -> Iterator[None]:
    """Add the file to errors raised inside the block that do not name one."""
    try:
        yield
    except TactileMapsError as error:
        if error.file is not None:
            raise
        raise error.at(file=file) from error


def write_crash_log(error: BaseException) -> Path:
    """Write the traceback of ``error`` to a new file in the user's log folder; return the file."""
    folder = user_log_path("tactile-maps", appauthor=False)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"crash {datetime.now():%Y-%m-%d %H.%M.%S.%f}.txt"
    path.write_text("".join(traceback.format_exception(error)), encoding="utf8")
    return path


def describe_unexpected_error(error: BaseException) -> str:
    """Return one sentence about an unexpected error that names the file with the details."""
    try:
        where = f"The details are in {write_crash_log(error)}"
    except OSError as failure:
        where = f"The details could not be written ({failure.strerror})"
    return f"an unexpected problem: {type(error).__name__}: {error}. {where}"


_PROGRAM = "tactile-maps"
"""Name of this program as a package."""


@contextmanager
def packages_of(extra: str) -> Iterator[None]:
    """Context for imports of packages that the extra ``extra`` of this program installs.

    Raises:
        ExportError: A package is not installed.
    """
    try:
        yield
    except ImportError as error:
        package = (error.name or str(error)).partition(".")[0]
        problem = "this format needs a package that is not installed"
        raise ExportError(problem, value=package, remedy=install_line(extra)) from error


def is_installed(module: str) -> bool:
    """Whether a module can be imported; it is not imported. ``module`` is a name without dots."""
    try:
        return find_spec(module) is not None
    except ValueError:  # it is known to be missing
        return False


def install_line(extra: str) -> str:
    """Return the command that installs the missing packages of an extra of this program into this environment.

    It names all packages of the extra if none is missing.
    """
    try:
        stated = requires(_PROGRAM) or []
    except PackageNotFoundError:  # used from its source, without having been installed
        stated = []
    needed = [one.partition(";")[0].strip() for one in stated if one.endswith(f"extra == '{extra}'")]
    missing = [one for one in needed if not _has(one)]
    words = [sys.executable, "-m", "pip", "install", *(missing or needed or [f"{_PROGRAM}[{extra}]"])]
    return subprocess.list2cmdline(words) if os.name == "nt" else shlex.join(words)


def _has(requirement: str) -> bool:
    """Whether the package of a requirement such as ``av>=12`` is installed, in any version."""
    name = requirement.partition(">")[0].partition("[")[0].strip()
    try:
        version(name)
    except PackageNotFoundError:
        return False
    return True
