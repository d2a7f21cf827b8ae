"""``guide``: where the guide's pages are. The window that shows them is opened by ``__main__``."""

from __future__ import annotations

import argparse
from pathlib import Path

from tactile_maps.cli.shared.output import print_fields, print_json
from tactile_maps.core.assets import asset
from tactile_maps.core.errors import UsageError, did_you_mean

START = "index"


def page_names() -> tuple[str, ...]:
    """The guide's pages by name, the start page first."""
    names = sorted(path.stem for path in asset("guide").glob("*.md"))
    return (START, *(name for name in names if name != START))


def find_page(name: str) -> Path:
    """The file of a page.

    Raises:
        UsageError: The guide has no such page.
    """
    known = page_names()
    if name not in known:
        raise UsageError("the guide has no such page", value=name, remedy=did_you_mean(name, known))
    return asset("guide", f"{name}.md")


def execute(arguments: argparse.Namespace) -> int:
    """Print where the page is."""
    path = find_page(arguments.page)
    if arguments.json:
        print_json({"page": arguments.page, "file": str(path), "pages": list(page_names())})
    else:
        print_fields({"Page": str(path), "Others": ", ".join(name for name in page_names() if name != arguments.page)})
    return 0
