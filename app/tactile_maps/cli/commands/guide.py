"""``guide``: paths of the guide's pages. ``__main__`` opens the window that shows them."""

from __future__ import annotations

import argparse
from pathlib import Path

from tactile_maps.cli.shared.output import print_result
from tactile_maps.core.assets import asset
from tactile_maps.core.errors import UsageError, did_you_mean

START = "index"


def page_names() -> tuple[str, ...]:
    """Return the names of the pages, the start page first."""
    names = sorted(path.stem for path in asset("guide").glob("*.md"))
    return (START, *(name for name in names if name != START))


def find_page(name: str) -> Path:
    """Return the file of a page.

    Raises:
        UsageError: The page does not exist.
    """
    known = page_names()
    if name not in known:
        raise UsageError("unknown page of the guide", value=name, remedy=did_you_mean(name, known))
    return asset("guide", f"{name}.md")


def execute(arguments: argparse.Namespace) -> int:
    """Print the path of the page."""
    path = find_page(arguments.page)
    result = {"page": arguments.page, "file": str(path), "pages": list(page_names())}
    others = ", ".join(name for name in page_names() if name != arguments.page)
    print_result(result, {"Page": path, "Others": others}, as_json=arguments.json)
    return 0
