"""The menus, as a table over the actions; what a menu lists by itself (robots, recent files) is added here too."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QMenu

from app.robots.library import robot_names
from widgets.overlays import MARKS, Ground
from widgets.panels.controller_choices import CHOICES, LAWS

if TYPE_CHECKING:
    from widgets.commands import Commands
    from widgets.main_window import MainWindow

LINE = ""
"""Between groups."""
ALIGN = ("align_left", "align_centre", "align_right", LINE, "align_top", "align_middle", "align_bottom")
MENUS = (
    (
        "Edit",
        ("undo", "redo", LINE, "arrange", "pins", "seams", "interest", LINE, "add_pin", "remove_pin", "select_pins",
         LINE, "propose_seam", "mirror", "true_size", "repack", LINE, "hide_patches", "show_patches", LINE,
         "cancel_edit"),
    ),
    ("Session", ("pause", "step", "reset", "record")),
    ("Touch", ("save_script", "play_script", LINE, "weigh")),
    (
        "Control",
        ("draw_path", "set_target", LINE, "more_force", "less_force", LINE, "clear_path", "start_again", LINE,
         "reset_gains", "compare_laws"),
    ),
    (
        "Select",
        ("poke", LINE, "select_box", "select_lasso", "select_brush", "smaller_brush", "larger_brush", LINE,
         "select_all", "select_none", "select_inverse"),
    ),
    (
        "View",
        ("frame", "morph", "compare", "theme", "panels", "timing", "effects", "plots", "reset_layout", "full_screen"),
    ),
    ("Help", ("keys", "about")),
)  # fmt: skip

OVERLAY = (
    *(f"ground_{ground.value}" for ground in Ground),
    LINE,
    *(f"mark_{name}" for name in MARKS),
)

PATHS = ("path_polyline", "path_spline", "path_lemniscate", "path_raster")

SUBMENUS = (
    ("Align", "Edit", "true_size", ALIGN),
    ("Law", "Control", "draw_path", tuple(f"law_{law}" for law in LAWS)),
    ("Task", "Control", "draw_path", tuple(f"task_{task}" for task in CHOICES["task"][1])),
    ("Path shape", "Control", "more_force", PATHS),
    ("Overlay", "View", "theme", OVERLAY),
)
"""Title, the menu it is in, before which action, and its actions."""


def build_menus(window: MainWindow, commands: Commands) -> None:
    """Fill the window's menu bar."""
    bar = window.menuBar()
    _build_file_menu(window, commands, bar.addMenu("File"))
    for title, names in MENUS:
        menu = bar.addMenu(title)
        menu.setToolTipsVisible(True)
        fill(menu, window, names)
        for inner, within, before, inner_names in SUBMENUS:
            if title == within:
                submenu = QMenu(inner, menu)
                submenu.setToolTipsVisible(True)
                menu.insertMenu(window.action(before), submenu)
                fill(submenu, window, inner_names)


def fill(menu: QMenu, window: MainWindow, names: tuple[str, ...]) -> None:
    """Add the actions called ``names``, with lines between groups."""
    for name in names:
        if name == LINE:
            menu.addSeparator()
        else:
            menu.addAction(window.action(name))


def _build_file_menu(window: MainWindow, commands: Commands, file: QMenu) -> None:
    file.addAction(window.action("open_robot"))
    robots = file.addMenu("Robots")
    for entry in robot_names():
        item = robots.addAction(entry.title)
        item.setObjectName(f"robot-{entry.name}")
        item.setEnabled(entry.available)
        item.setToolTip(entry.remedy)
        item.triggered.connect(partial(commands.open_robot, entry.name))
    robots.setToolTipsVisible(True)
    scenes = file.addMenu("Open scene")
    scenes.setObjectName("scenes")
    window.scenes.fill(scenes)
    fill(file, window, ("import_taxels", "open_recording"))
    recent = file.addMenu("Recent files")
    recent.aboutToShow.connect(partial(_list_recent, recent, window, commands))
    file.addSeparator()
    fill(
        file,
        window,
        ("open_map", "save_map", "save_map_as", "export_map", LINE, "save_scene", LINE, "save_picture", LINE, "quit"),
    )


def _list_recent(menu: QMenu, window: MainWindow, commands: Commands) -> None:
    menu.clear()
    for path in window.settings.recent:
        menu.addAction(path).triggered.connect(partial(commands.open_path, path))
    if menu.isEmpty():
        menu.addAction("Nothing opened yet").setEnabled(False)
