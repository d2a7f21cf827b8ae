"""YAML files with plain values only, without tags for objects and without aliases."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from tactile_maps.core.errors import RobotError, TactileMapsError, install_line

_UNITS = {
    "!radians": 1.0,
    "!degrees": math.radians(1.0),
    "!meters": 1.0,
    "!millimeters": 1e-3,
    "!centimeters": 1e-2,
    "!foot": 0.3048,
    "!inches": 0.0254,
}
_MAX_BYTES = 2**20


def parse_yaml(data: bytes, file: Path, *, error: type[TactileMapsError] = RobotError) -> Any:
    """Return the content of a YAML file: dictionaries, lists, numbers and texts; quantities with a unit in SI.

    Raises:
        TactileMapsError: PyYAML is not installed, or the file is too large, not YAML, or has aliases or other tags;
            raised as ``error``.
    """
    try:
        import yaml  # an optional package
    except ImportError as cause:
        problem = "this file needs a package that is not installed"
        remedy = install_line("xacro")
        raise error(problem, file=file, value="PyYAML", remedy=remedy) from cause
    if len(data) > _MAX_BYTES:
        raise error("the file is too large", file=file, value=f"{len(data)} bytes", remedy="The maximum is 1 MiB")

    class Loader(yaml.SafeLoader):
        """Safe loader of PyYAML without aliases."""

        def compose_node(self, parent: Any, index: Any) -> Any:
            if self.check_event(yaml.events.AliasEvent):
                raise yaml.composer.ComposerError
            return super().compose_node(parent, index)

    for tag, unit in _UNITS.items():
        Loader.add_constructor(tag, lambda loader, node, unit=unit: unit * float(loader.construct_scalar(node)))
    try:
        return Loader(data).get_single_data()
    except (yaml.YAMLError, ValueError, RecursionError) as cause:
        where = getattr(getattr(cause, "problem_mark", None), "line", None)
        place = None if where is None else f"line {where + 1}"
        reasons: dict[type[Exception], str] = {  # PyYAML's messages quote the untrusted file
            yaml.constructor.ConstructorError: "a tag or key that is not supported",
            yaml.composer.ComposerError: "several documents, or an alias",
            yaml.MarkedYAMLError: "lists, keys or indentation that do not fit",
            yaml.YAMLError: "characters that YAML does not allow",
            RecursionError: "lists and keys are nested too deep",
            ValueError: "a number that cannot be read",
        }
        value = next(words for kind, words in reasons.items() if isinstance(cause, kind))
        remedy = "Use lists, keys, numbers and texts alone"
        problem = "the file is not YAML with plain values"
        raise error(problem, file=file, place=place, value=value, remedy=remedy) from cause
