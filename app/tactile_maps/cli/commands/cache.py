"""``cache``: the prepared scenes that are kept on disk: where, how many, and removing them."""

from __future__ import annotations

import argparse

from tactile_maps.cli.shared.output import print_fields, print_json
from tactile_maps.core.errors import UsageError
from tactile_maps.core.files import FOLDER_VARIABLE
from tactile_maps.session.prepared_cache import MOST_BYTES, cache_content, clear_cache


def execute(arguments: argparse.Namespace) -> int:
    """Say what is kept, or remove it."""
    content = clear_cache() if arguments.clear else cache_content()
    if content.folder is None:
        problem = "nothing is kept on disk"
        raise UsageError(problem, place=FOLDER_VARIABLE, value="off", remedy="Unset it, or let it name a folder")
    if arguments.json:
        print_json(
            {
                "folder": str(content.folder),
                "scenes": content.entries,
                "bytes": content.size,
                "cleared": arguments.clear,
            }
        )
    else:
        print_fields(
            {
                "Folder": content.folder,
                "Removed" if arguments.clear else "Prepared scenes": content.entries,
                "Size": f"{content.size / 1e6:.1f} MB" + ("" if arguments.clear else f" of {MOST_BYTES / 1e6:.0f} MB"),
            }
        )
    return 0
