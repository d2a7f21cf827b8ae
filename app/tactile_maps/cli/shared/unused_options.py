"""Rejects options that have no effect: without another option, next to another option, or with the given input."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping

from tactile_maps.core.errors import UsageError

PLACEMENT = ("--taxels", "--pitch", "--pattern", "--density", "--keep-border", "--axes")
"""Options of ``map`` that say how taxels are placed."""
NEEDED: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "run": {
        "--host": ("--serve",),
        "--port": ("--serve",),
        "--no-viewers": ("--output",),
        "--overwrite": ("--output",),
    },
    "listen": {
        "--max-speed": ("--send",),
        "--max-force": ("--send",),
        "--send-anyway": ("--send",),
        "--weight-seconds": ("--weight",),
        "--save-calibration": ("--weight",),
        "--overwrite": ("--output", "--save-calibration"),
    },
    "check": {"--overwrite": ("--report",)},
    "screenshot": dict.fromkeys(("--mm", "--dpi", "--colours"), ("--figure",)),
    "inspect": {"--overwrite": ("--report",)},
    "weigh": {"--overwrite": ("--report",)},
    "place": {
        "--readings": ("--touches",),
        "--changes": ("--touches",),
        "--overwrite": ("--output", "--report"),
    },
    "calibrate": {"--overwrite": ("--output", "--report")},
    "replay": {"--overwrite": ("--stimuli",)},
    "compare": {"--overwrite": ("--output",)},
    "map": {
        "--babble": ("--learn",),
        "--touches": ("--learn",),
        "--fix-modules": ("--compare",),
        "--overwrite": ("--output",),
    },
}
"""Options by command that have no effect without one of some others."""
REPLACED: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "screenshot": {"--figure": ("--theme", "--size")},
    "inspect": {
        "--plugins": ("--report", "--costs", "--package-root", "--mapping"),
        "--mapping": ("--report", "--costs", "--package-root", "--home", "--json"),
    },
    "place": {"--touches": ("--home", "--seed")},
    "trim": {"--episodes": ("--from", "--to")},
    "map": {
        "--grid": (*(option for option in PLACEMENT if option != "--axes"), "--surface", "--robot"),
        "--pitch": ("--taxels",),
        "--uv": ("--method", "--lengths", "--cut"),
        "--learn": ("--uv", "--method", "--lengths", "--cut"),
    },
}
"""Options by command that have no effect next to another one."""


def given_options(arguments: argparse.Namespace) -> frozenset[str]:
    """Return the options on the command line, each by all its names, those with their default value included."""
    found: frozenset[str] = getattr(arguments, "given", frozenset())
    return found


def refuse_unused_options(command: str, arguments: argparse.Namespace) -> None:
    """Reject options of a command that have no effect given the other options; raises UsageError."""
    given = given_options(arguments)
    for option, needed in NEEDED.get(command, {}).items():
        if option in given and given.isdisjoint(needed):
            others = " or ".join(needed)
            problem = f"this option has no effect without {others}"
            raise UsageError(problem, place=option, remedy=f"Add {others}, or remove {option}")
    for other, replaced in REPLACED.get(command, {}).items():
        for option in replaced:
            if {option, other} <= given:
                remedy = f"Remove {option} or {other}"
                raise UsageError(f"this option has no effect next to {other}", place=option, remedy=remedy)


def refuse_with_input(
    arguments: argparse.Namespace, options: Iterable[str], noun: str, value: object, *, purpose: str
) -> None:
    """Reject options that have no effect with the input of a command.

    Args:
        arguments: Parsed command line.
        options: Names of the options.
        noun: Kind of the input, for example ``file``.
        value: The input.
        purpose: Purpose of the options, as a sentence without a full stop.

    Raises:
        UsageError: An option of ``options`` is on the command line.
    """
    for option in options:
        if option in given_options(arguments):
            problem = f"this option has no effect with this {noun}"
            raise UsageError(problem, place=option, value=value, remedy=f"{purpose}: remove {option}")
