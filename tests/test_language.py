"""Docstrings and names use plain technical English; the remaining exceptions are counted for each folder.

    python -m tests.test_language        # the present counts, as the table ``MOST`` below
    python -m tests.test_language -v     # each place that is counted

A docstring begins with a noun or a verb. Names use the words of the field.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
OPENING = re.compile(r"(Of|By|As|In|Those|Which|What|Whether)\b")
WORD = re.compile(
    r"(^|_)(tells?|told|wants?|wanted|wish|wishes|wished|besides?|lies?|stands?|stood|whoever|nobody|somebody|anew|likewise"
    r"|worn|wears?|asked|answers?|answered|owed|mends?|mended|heeds?|heeded|sights?|laws?|readers?|grounds?|courses?)(?=_|$)"
)
HUMP = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")
ALLOWED = {
    "stand_in": "noun: what is drawn in place of a missing mesh",
    "line_of_sight": "term of optics",
}
"""Parts of names that contain such a word and are usual terms, each with the reason."""
MOST: dict[str, tuple[int, int]] = {
    "app/tactile_maps/core": (0, 3),
    "app/tactile_maps/editing": (0, 1),
    "app/tactile_maps/geometry": (0, 3),
    "app/tactile_maps/live": (0, 4),
    "app/tactile_maps/maps": (0, 7),
    "app/tactile_maps/recording": (0, 1),
    "app/tactile_maps/robots": (0, 1),
    "app/tactile_maps/scene": (0, 8),
    "app/tactile_maps/studies": (5, 0),
    "tests": (5, 177),
    "widgets/tactile_widgets": (0, 1),
    "widgets/tactile_widgets/panels": (0, 1),
    "widgets/tactile_widgets/presenters": (0, 13),
}
"""Docstrings and names by folder, at most; lower the numbers with every change that lowers the counts."""


def findings_of(source: str) -> tuple[list[str], list[str]]:
    """Return docstrings that open with a word of ``OPENING``, and names with a word of ``WORD``, each with its line.

    Docstrings include those of attributes. *Whether* is accepted for a bool, and for a function that returns one.
    Names are those of functions, classes, arguments, variables and attributes where they are defined.
    """
    texts = []
    words = []
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                texts += _openings(node, node.body)
            case ast.arg(arg=name) | ast.Name(id=name, ctx=ast.Store()) | ast.Attribute(attr=name, ctx=ast.Store()):
                pass
            case ast.Module(body=body):
                texts += _openings(node, body)
                continue
            case _:
                continue
        if _is_avoided(name):
            words.append(f"{node.lineno}: {name}")
    return texts, words


def _openings(owner: ast.AST, body: list[ast.stmt]) -> Iterator[str]:
    for statement in body:
        value = statement.value if isinstance(statement, ast.Expr) else None
        if isinstance(value, ast.Constant) and isinstance(value.value, str):
            found = OPENING.match(value.value)
            if found and not (found[0] == "Whether" and _is_bool(owner)):
                yield f"{statement.lineno}: {value.value.partition(chr(10))[0]}"
        owner = statement


def _is_bool(owner: ast.AST) -> bool:
    kind = getattr(owner, "returns", None) or getattr(owner, "annotation", None)
    return kind is not None and ast.unparse(kind) == "bool"


def _is_avoided(name: str) -> bool:
    words = HUMP.sub("_", name).lower()
    for phrase in ALLOWED:
        words = words.replace(phrase, "")
    return WORD.search(words) is not None


def findings() -> dict[str, tuple[list[str], list[str]]]:
    """Return what ``findings_of`` finds by folder of a package, and in all tests, each with its place."""
    found: dict[str, tuple[list[str], list[str]]] = {}
    for path in sorted(file for top in ("app", "widgets", "tests") for file in (ROOT / top).rglob("*.py")):
        place = path.relative_to(ROOT)
        folder = "tests" if place.parts[0] == "tests" else "/".join(place.parts[:-1][:3])
        kinds = found.setdefault(folder, ([], []))
        for kind, counted in zip(kinds, findings_of(path.read_text(encoding="utf8")), strict=True):
            kind += [f"{place.as_posix()}:{each}" for each in counted]
    return found


@pytest.mark.long
def test_number_of_docstrings_and_names_to_avoid_does_not_increase():
    more = []
    for folder, kinds in findings().items():
        for found, most, kind in zip(kinds, MOST.get(folder, (0, 0)), ("docstrings", "names"), strict=True):
            if len(found) > most:
                more += [f"{folder}: {len(found)} {kind}, at most {most}", *found[:20]]
    assert not more, "\n".join(more)


def test_docstrings_that_start_with_nouns_verbs_or_predicates_are_not_counted():
    source = """
class WantedMotion:
    closed: bool
    'Whether it is closed.'
    speed: float
    'Of any joint.'
    def is_open(self) -> bool:
        'Whether it is open.'
    def size(self, stand_in):
        'What size.'
        understand = self.handle.tell()
        told = 1
"""
    assert findings_of(source) == (["6: Of any joint.", "10: What size."], ["2: WantedMotion", "12: told"])


if __name__ == "__main__":
    for where, (docstrings, avoided) in findings().items():
        if "-v" in sys.argv:
            print(*docstrings, *avoided, sep="\n")
        elif docstrings or avoided:
            print(f'    "{where}": ({len(docstrings)}, {len(avoided)}),')
