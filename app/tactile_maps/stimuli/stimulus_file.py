"""Stimuli as TOML files."""

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
"""Kinds of stimuli by their names in files."""
_MAX_BYTES = 10_000_000
MAX_STIMULI = 20_000
"""Largest number of stimuli in a script; reading one takes 0.1 ms."""
_TABLE = re.compile(r"^[ \t]*\[\[", re.MULTILINE)


def load_stimuli(path: str | FilePath) -> tuple[Stimulus, ...]:
    """Read a script: a TOML file of ``[[stimuli]]`` tables.

    Raises:
        SceneError: The file cannot be read or is invalid; the error names line and key.
    """
    data = read_bounded_file(FilePath(path), error=SceneError, most=_MAX_BYTES)
    try:
        text = data.decode("utf8")
    except UnicodeDecodeError as error:
        raise SceneError("the file is not text", file=path, value=error) from error
    return stimuli_from_toml(text, file=str(path))


def save_stimuli(stimuli: Sequence[Stimulus], path: str | FilePath) -> None:
    """Write a script atomically.

    Raises:
        SceneError: The file cannot be written.
    """
    write_atomically(FilePath(path), stimuli_to_toml(stimuli).encode("utf8"), error=SceneError)


def stimuli_from_toml(text: str, *, file: str) -> tuple[Stimulus, ...]:
    """Read a script.

    Args:
        text: TOML text.
        file: Name of its file, for errors.

    Raises:
        SceneError: The text is invalid; the error names line, key, value and valid values.
    """
    if (count := len(_TABLE.findall(text))) > MAX_STIMULI:
        remedy = f"The maximum is {MAX_STIMULI}: split the script"
        raise SceneError(f"the script has more than {MAX_STIMULI} stimuli", file=file, value=count, remedy=remedy)
    document = TomlReader(text, file=file)
    for key in document.raw:
        if key != "stimuli":
            remedy = "Write [[stimuli]] above each one's lines"
            raise document.error_at("unknown key in a stimulus file", (key,), value=key, remedy=remedy)
    return tuple(read_stimulus(document, *place) for place in document.tables("stimuli"))


def stimuli_to_toml(stimuli: Sequence[Stimulus]) -> str:
    """Return a script as text; reading it gives equal stimuli."""
    return "\n".join("[[stimuli]]\n" + _lines(stimulus_to_table(stimulus)) for stimulus in stimuli)


def read_stimulus(document: TomlReader, table: Mapping[str, Any], path: KeyPath) -> Stimulus:
    """Return the stimulus of a table at ``path`` of a scene's or a script's text.

    Raises:
        SceneError: The table is invalid; the error names line, key, value and valid values.
    """
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in STIMULUS_KINDS:
        problem = "unknown kind of stimulus" if kind is not None else "the kind of the stimulus is missing"
        remedy = did_you_mean(kind if isinstance(kind, str) else "", tuple(STIMULUS_KINDS))
        raise document.error_at(problem, (*path, "kind"), value=kind, remedy=remedy)
    return document.build(STIMULUS_KINDS[kind], {key: value for key, value in table.items() if key != "kind"}, path)


def stimulus_to_table(stimulus: Stimulus) -> dict[str, Any]:
    """Return a stimulus as a table of a scene or a script: its kind and the values that are not defaults."""
    usual = {field.name: field.default for field in fields(stimulus)}
    # Time and place come first.
    order = sorted(usual, key=lambda name: name not in ("begin", "patch", "at", "start", "end"))
    changed = {name: getattr(stimulus, name) for name in order if getattr(stimulus, name) != usual[name]}
    return {"kind": stimulus.kind, **changed}


def _lines(table: Mapping[str, Any]) -> str:
    """Return the lines of a table: one per key, for a path one per point."""
    lines = []
    for key, value in table.items():
        if key == "points":
            lines += [f"{key} = [", *(f"  {toml_value(point)}," for point in value), "]"]
        else:
            lines.append(toml_lines({key: value}))
    return "\n".join(lines) + "\n"
