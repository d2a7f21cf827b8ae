"""The program: joins the command line with the window. The only module of ``app`` that may import ``widgets``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from app.cli.main import run_command
from app.cli.output import print_fields, print_json, progress_line
from app.core.errors import DisplayError


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; the exit code is returned."""
    words = list(sys.argv[1:] if argv is None else argv)
    return run_command(words, windows={"gui": _gui, "guide": _guide, "screenshot": _screenshot})


def main_gui() -> int:
    """The window, for a desktop's launcher."""
    return main(["gui", *sys.argv[1:]])


def _gui(arguments: argparse.Namespace) -> int:
    from widgets.window.display import require_display

    require_display()  # before the scene and the window are imported, which takes seconds
    from app.cli.scenes import scene_from_arguments
    from widgets.window.application import launch

    return launch(scene_from_arguments(arguments))


def _guide(arguments: argparse.Namespace) -> int:
    from app.cli.commands.guide import execute, find_page

    page = find_page(arguments.page)
    if arguments.json:
        return execute(arguments)
    from widgets.window.display import require_display

    try:
        require_display()
    except DisplayError:
        return execute(arguments)
    from widgets.window.application import show_guide

    return show_guide(page)


def _screenshot(arguments: argparse.Namespace) -> int:
    from app.cli.scenes import scene_from_arguments
    from widgets.window.application import screenshot

    report = progress_line()
    screenshot(
        scene_from_arguments(arguments),
        arguments.output,
        at=arguments.at,
        theme=arguments.theme,
        size=arguments.size,
        progress=report,
    )
    report("", 1.0)
    width, height = arguments.size
    if arguments.json:
        print_json({"file": arguments.output, "width": width, "height": height, "at_s": arguments.at})
    else:
        print_fields({"Written to": arguments.output, "Size": f"{width} x {height}"})
    return 0


if __name__ == "__main__":
    sys.exit(main())
