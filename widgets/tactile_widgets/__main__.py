"""The program ``tactile-maps``: the command line, with the commands that open a window or draw one."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path

from tactile_maps.cli.main import run_command
from tactile_maps.cli.shared.output import print_fields, print_json, print_warning, progress_line
from tactile_maps.core.errors import DisplayError, UsageError
from tactile_maps.core.file_kinds import FileKind


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    return run_command(words, windows={"gui": _gui, "guide": _guide, "screenshot": _screenshot, "film": _film})


def main_gui() -> int:
    """The window, for a desktop's launcher."""
    return main(["gui", *sys.argv[1:]])


def _gui(arguments: argparse.Namespace) -> int:
    from tactile_widgets.window.display import require_display

    require_display()  # before the scene and the window are imported, which takes seconds
    from tactile_maps.cli.shared.scenes import scene_from_arguments
    from tactile_maps.skin.formats.identify import identify
    from tactile_widgets.common.file_dialogs import OPENED
    from tactile_widgets.window.application import launch

    file = getattr(arguments, "file", None)
    if file is None:
        return launch(scene_from_arguments(arguments), file=_scene_file(arguments))
    option = _GUI_OPTIONS.get(identify(file, expected=OPENED))
    if option is None:
        return launch(scene_from_arguments(arguments), file=_scene_file(arguments), then=file)
    if getattr(arguments, option, None) is not None:
        remedy = f"Give FILE or --{option}"
        raise UsageError(f"a {option} is named twice", file=file, value=getattr(arguments, option), remedy=remedy)
    setattr(arguments, option, [file] if option == "skin" else file)
    return launch(scene_from_arguments(arguments), file=_scene_file(arguments))


def _scene_file(arguments: argparse.Namespace) -> Path | None:
    """Return the file of the scene; None for a scene of the program, or with another robot or skin."""
    from tactile_maps.scene.scene_file import scene_names

    given = vars(arguments)
    named = given.get("scene")
    changed = given.get("robot") or given.get("skin")
    if not named or named in scene_names() or changed or Path(named).is_dir():
        return None
    return Path(named).absolute()


_GUI_OPTIONS = {
    FileKind.SCENE: "scene",
    FileKind.ROBOT: "robot",
    FileKind.ROBOT_WITH_TAXELS: "robot",
    FileKind.MESH: "robot",
    FileKind.TAXELS: "skin",
    FileKind.LAYOUT: "skin",
    FileKind.SKIN: "skin",
}
"""Option of the command line by which a file is opened; other kinds are opened once the window is shown."""


def _guide(arguments: argparse.Namespace) -> int:
    from tactile_maps.cli.commands.guide import execute, find_page

    page = find_page(arguments.page)
    if arguments.json:
        return execute(arguments)
    from tactile_widgets.window.display import require_display

    try:
        require_display()
    except DisplayError:
        return execute(arguments)
    from tactile_widgets.window.application import show_guide

    return show_guide(page)


def _screenshot(arguments: argparse.Namespace) -> int:
    if arguments.figure is not None:
        return _figure(arguments)
    from tactile_widgets.window.window_picture import check_picture_kind

    check_picture_kind(arguments.output)  # before the window is imported and the scene prepared, which takes seconds
    from tactile_maps.cli.shared.scenes import scene_from_arguments
    from tactile_widgets.window.application import screenshot

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


def _figure(arguments: argparse.Namespace) -> int:
    from tactile_widgets.dialogs.figures.figure_file import FigureColours, FigureSpec, check_figure_kind

    width, height = arguments.mm
    spec = FigureSpec(width, height, arguments.dpi, FigureColours(arguments.colours))
    check_figure_kind(arguments.output)
    from tactile_maps.cli.shared.scenes import scene_from_arguments
    from tactile_widgets.window.application import figure

    report = progress_line()
    left_out = figure(
        scene_from_arguments(arguments),
        arguments.output,
        spec,
        part=arguments.figure,
        at=arguments.at,
        progress=report,
    )
    report("", 1.0)
    if left_out:
        print_warning(left_out)
    if arguments.json:
        facts = {"file": arguments.output, "width_mm": spec.width, "height_mm": spec.height, "dpi": spec.dpi}
        print_json(facts | {"at_s": arguments.at})
    else:
        print_fields({"Written to": arguments.output, "Size": f"{spec.width:g} x {spec.height:g} mm, {spec.dpi} dpi"})
    return 0


def _film(arguments: argparse.Namespace) -> int:
    from tactile_widgets.dialogs.figures.view_film import film_recording

    report = progress_line()
    asked = arguments.first is not None or arguments.last is not None
    span = (arguments.first or 0.0, math.inf if arguments.last is None else arguments.last) if asked else None
    try:
        player = film_recording(
            arguments.input,
            arguments.output,
            size=arguments.size,
            rate=arguments.rate,
            theme=arguments.theme,
            span=span,
            overwrite=arguments.overwrite,
            progress=report,
        )
    finally:
        report("", 1.0)
    for text in player.damage_texts:
        print_warning(text)
    width, height = arguments.size
    seconds = player.duration if span is None else min(span[1], player.duration) - span[0]
    if arguments.json:
        facts = {"file": arguments.output, "width": width, "height": height, "seconds": seconds}
        print_json(facts | {"rate": arguments.rate, "complete": player.complete})
    else:
        size = f"{width} x {height}, {arguments.rate:g} pictures a second"
        print_fields({"Written to": arguments.output, "Size": size, "Duration": f"{seconds:.2f} s"})
    return 0


if __name__ == "__main__":
    sys.exit(main())
