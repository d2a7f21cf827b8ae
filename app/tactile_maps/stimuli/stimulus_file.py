"""Stimuli as TOML: read with every mistake named, written as a person would write them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path as FilePath
from types import MappingProxyType
from typing import Any

from tactile_maps.core.errors import SceneError, did_you_mean
from tactile_maps.core.files import read_bounded_file, write_atomically
from tactile_maps.core.toml import KeyPath, TomlReader, toml_lines, toml_value
from tactile_maps.stimuli.stimulus import Stimulus
from tactile_maps.stimuli.stimulus_kinds import Babble, FingerPath, Grasp, Poke, Roll, Stroke, Tap

STIMULUS_KINDS: Mapping[str, type[Stimulus]] = MappingProxyType(
    {kind.kind: kind for kind in (Poke, Stroke, Tap, Roll, Grasp, Babble, FingerPath)}
)
"""All kinds of stimuli, by what a file calls them."""
_MAX_BYTES = 10_000_000
MAX_STIMULI = 20_000
"""Stimuli of a script; reading one takes 0.1 ms."""
_TABLE = re.compile(r"^[ \t]*\[\[", re.MULTILINE)


def load_stimuli(path: str | FilePath) -> tuple[Stimulus, ...]:
    """Read a script: a TOML file of ``[[stimuli]]`` tables.

    Raises:
        SceneError: The file cannot be read, or has a mistake; the message names the line and the key.
    """
    data = read_bounded_file(FilePath(path), error=SceneError, most=_MAX_BYTES)
    try:
        text = data.decode("utf8")
    except UnicodeDecodeError as error:
        raise SceneError("the file is not text", file=path, value=error) from error
    return stimuli_from_toml(text, file=str(path))


def save_stimuli(stimuli: Sequence[Stimulus], path: str | FilePath) -> None:
    """Write a script, whole or not at all.

    Raises:
        SceneError: It cannot be written.
    """
    write_atomically(FilePath(path), stimuli_to_toml(stimuli).encode("utf8"), error=SceneError)


def stimuli_from_toml(text: str, *, file: str) -> tuple[Stimulus, ...]:
    """Read a script.

    Args:
        text: TOML.
        file: Where the text came from, for messages.

    Raises:
        SceneError: Naming line and key, the value, what is allowed there and the nearest spelling.
    """
    if (count := len(_TABLE.findall(text))) > MAX_STIMULI:
        remedy = f"The most is {MAX_STIMULI}: split the script"
        raise SceneError(f"the script has more than {MAX_STIMULI} stimuli", file=file, value=count, remedy=remedy)
    reader = TomlReader(text, file=file)
    for key in reader.raw:
        if key != "stimuli":
            remedy = "Write [[stimuli]] above each one's lines"
            raise reader.error_at("a stimulus file holds stimuli alone", (key,), value=key, remedy=remedy)
    return tuple(read_stimulus(reader, *place) for place in reader.tables("stimuli"))


def stimuli_to_toml(stimuli: Sequence[Stimulus]) -> str:
    """The same script as text; reading it gives equal stimuli."""
    return "\n".join("[[stimuli]]\n" + _lines(stimulus_to_table(stimulus)) for stimulus in stimuli)


def read_stimulus(reader: TomlReader, table: Mapping[str, Any], path: KeyPath) -> Stimulus:
    """One stimulus from its table at ``path`` of a scene's or a script's text.

    Raises:
        SceneError: Naming line and key, the value, what is allowed there and the nearest spelling.
    """
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in STIMULUS_KINDS:
        problem = "there is no such kind of stimulus" if kind is not None else "a stimulus must say its kind"
        remedy = did_you_mean(kind if isinstance(kind, str) else "", tuple(STIMULUS_KINDS))
        raise reader.error_at(problem, (*path, "kind"), value=kind, remedy=remedy)
    return reader.build(STIMULUS_KINDS[kind], {key: value for key, value in table.items() if key != "kind"}, path)


def stimulus_to_table(stimulus: Stimulus) -> dict[str, Any]:
    """A stimulus as a table of a scene or a script: its kind, and what is not as usual for that kind."""
    usual = {field.name: field.default for field in fields(stimulus)}
    # When and where come first, as a person would say it.
    order = sorted(usual, key=lambda name: name not in ("begin", "patch", "at", "start", "end"))
    changed = {name: getattr(stimulus, name) for name in order if getattr(stimulus, name) != usual[name]}
    return {"kind": stimulus.kind, **changed}


def _lines(table: Mapping[str, Any]) -> str:
    """One line a key; a long way is one point a line."""
    lines = []
    for key, value in table.items():
        if key == "points":
            lines += [f"{key} = [", *(f"  {toml_value(point)}," for point in value), "]"]
        else:
            lines.append(toml_lines({key: value}))
    return "\n".join(lines) + "\n"
