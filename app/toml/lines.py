"""Values as lines of TOML that read back as they were, to the last digit."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any


def toml_lines(values: Mapping[str, Any]) -> str:
    """One line a key: words, numbers, lists and tables of these."""
    return "\n".join(f"{_key(key)} = {toml_value(value)}" for key, value in values.items())


def toml_value(value: Any) -> str:
    """One value as TOML writes it; a tuple becomes a list, a mapping an inline table."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        # JSON's escapes are TOML's too, but for DEL, which TOML wants escaped.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, tuple | list):
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(key)} = {toml_value(item)}" for key, item in value.items()) + "}"
    return repr(value)


def _key(key: str) -> str:
    return key if re.fullmatch("[A-Za-z0-9_-]+", key) else toml_value(key)
