"""``cache``: location, number and removal of the prepared scenes on disk."""

from __future__ import annotations

import argparse

from tactile_maps.cli.shared.output import print_result
from tactile_maps.core.errors import UsageError
from tactile_maps.core.files import FOLDER_VARIABLE
from tactile_maps.session.prepared_cache import MOST_BYTES, cache_content, clear_cache


def execute(arguments: argparse.Namespace) -> int:
    """Print the content of the cache, or remove it."""
    content = clear_cache() if arguments.clear else cache_content()
    if content.folder is None:
        problem = "the cache is switched off"
        raise UsageError(problem, place=FOLDER_VARIABLE, value="off", remedy="Unset it, or set it to a folder")
    result = {
        "folder": str(content.folder),
        "scenes": content.entries,
        "bytes": content.size,
        "cleared": arguments.clear,
    }
    limit = "" if arguments.clear else f" of {MOST_BYTES / 1e6:.0f} MB"
    number = "Removed" if arguments.clear else "Prepared scenes"
    rows = {"Folder": content.folder, number: content.entries, "Size": f"{content.size / 1e6:.1f} MB{limit}"}
    print_result(result, rows, as_json=arguments.json)
    return 0
