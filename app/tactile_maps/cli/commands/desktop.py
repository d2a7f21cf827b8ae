"""``desktop``: add the window to the menu of a Linux desktop: entry, icon and file types, for one user.

Follows the freedesktop.org specifications "Desktop Entry" 1.5, "Icon Theme", "Shared MIME-info Database" and "XDG Base
Directory". Only recordings and maps are registered; scenes, robots and tables are TOML, XML and text, which belong to
editors.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

from tactile_maps.cli.shared.output import print_fields, print_json
from tactile_maps.core.assets import asset
from tactile_maps.core.errors import TactileMapsError, UsageError
from tactile_maps.core.files import make_output_folder, write_atomically

NAME = "tactile-maps"
"""Name of the files, and of the window, with which a desktop associates the window with the entry."""
_RECORDING = "application/x-mcap"
_ARRAYS = "application/x-npz"
_MIME_TYPES = f"""<?xml version="1.0" encoding="UTF-8"?>
<mime-info xmlns="http://www.freedesktop.org/standards/shared-mime-info">
  <mime-type type="{_RECORDING}">
    <comment>MCAP recording</comment>
    <magic priority="60"><match type="string" offset="0" value="\\x89MCAP0\\r\\n"/></magic>
    <glob pattern="*.mcap"/>
  </mime-type>
  <mime-type type="{_ARRAYS}">
    <comment>NumPy arrays</comment>
    <sub-class-of type="application/zip"/>
    <glob pattern="*.npz"/>
  </mime-type>
</mime-info>
"""


def execute(arguments: argparse.Namespace) -> int:
    """Write or remove the files."""
    if not sys.platform.startswith("linux"):
        problem = "desktop entries are for Linux"
        raise UsageError(problem, value=sys.platform, remedy="Make a shortcut to tactile-maps by hand")
    entry, icon, types = desktop_files()
    found = [path for path in (entry, icon, types) if path.exists()]
    if arguments.remove:
        for path in found:
            path.unlink()
    else:
        for path, data in (
            (icon, asset("icon.svg").read_bytes()),
            (types, _MIME_TYPES.encode()),
            (entry, desktop_entry(launcher()).encode()),
        ):
            _write(path, data)
    _update_desktop(entry, types)
    written = {"entry": str(entry), "icon": str(icon), "types": str(types)}
    done = {"removed": [str(path) for path in found]} if arguments.remove else written
    if arguments.json:
        print_json(done)
    elif arguments.remove:
        print_fields({"Removed": [str(path) for path in found] or "nothing: no entry was installed"})
    else:
        print_fields(
            {"Entry": entry, "Icon": icon, "File types": types, "Remove with": "tactile-maps desktop --remove"}
        )
    return 0


def _update_desktop(entry: Path, types: Path) -> None:
    """Rebuild the desktop's databases with its tools; desktops without these tools read the files themselves."""
    for tool, folder in (("update-mime-database", types.parent.parent), ("update-desktop-database", entry.parent)):
        program = shutil.which(tool)
        if program is not None and folder.is_dir():
            subprocess.run([program, str(folder)], check=False, capture_output=True)


def desktop_files() -> tuple[Path, Path, Path]:
    """Return the paths of entry, icon and file types, under ``$XDG_DATA_HOME`` or ``~/.local/share``."""
    stated = os.environ.get("XDG_DATA_HOME", "")
    folder = Path(stated) if Path(stated).is_absolute() else Path.home() / ".local" / "share"
    icons = folder / "icons" / "hicolor" / "scalable" / "apps"
    types = folder / "mime" / "packages" / f"{NAME}.xml"
    return folder / "applications" / f"{NAME}.desktop", icons / f"{NAME}.svg", types


def launcher() -> tuple[str, ...]:
    """Return the command line that opens the window from any folder: the installed command, or this Python."""
    command = Path(sys.executable).with_name(NAME)
    return (str(command), "gui") if command.exists() else (sys.executable, "-m", "tactile_maps", "gui")


def desktop_entry(words: tuple[str, ...]) -> str:
    """Return the text of the entry that runs ``words``."""
    return "\n".join(
        (
            "[Desktop Entry]",
            "Type=Application",
            "Version=1.5",
            "Name=Tactile Maps",
            "GenericName=Robot skin",
            "Comment=Tactile maps of robot skin: simulate, control contact, record and measure",
            f"Exec={' '.join(map(_quoted, words))} %f",
            f"MimeType={_RECORDING};{_ARRAYS};",
            f"Icon={NAME}",
            "Terminal=false",
            "Categories=Science;Robotics;Education;",
            "Keywords=robot;skin;tactile;taxel;contact;",
            "StartupNotify=true",
            f"StartupWMClass={NAME}",
            "",
        )
    )


def _quoted(word: str) -> str:
    """Quote a word for the key Exec, whose values are unescaped twice, with doubled percent signs."""
    for sign in ("\\", '"', "`", "$"):
        word = word.replace(sign, f"\\{sign}")
    return '"{}"'.format(word.replace("\\", "\\\\").replace("%", "%%"))


def _write(path: Path, data: bytes) -> None:
    try:
        make_output_folder(path.parent, error=TactileMapsError)
    except TactileMapsError as error:
        raise error.at(remedy="Set XDG_DATA_HOME to a folder that can be written") from error
    write_atomically(path, data, error=TactileMapsError)
