"""Settings of the window that are stored between launches, in one readable file.

``OverlayOptions`` is the setting of View > Overlay: the base layer of the map, and the layers that are shown.
"""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from platformdirs import user_config_path, user_documents_path
from PySide6.QtCore import QByteArray, QSettings


class BaseLayer(Enum):
    """Colouring of untouched skin; each value is the end of the name of the action that chooses it."""

    PRESSURE = "pressure"
    ANGLE = "angle"
    AREA = "area"
    CHECKER = "checker"
    CIRCLES = "circles"

    @property
    def title(self) -> str:
        """Title in the legend."""
        return _TITLES[self]


_TITLES = {
    BaseLayer.PRESSURE: "Pressure",
    BaseLayer.ANGLE: "Angle distortion",
    BaseLayer.AREA: "Area distortion",
    BaseLayer.CHECKER: "Checker",
    BaseLayer.CIRCLES: "Circles",
}


@dataclass(frozen=True)
class OverlayOptions:
    """The setting of View > Overlay.

    Attributes:
        base: Colouring of untouched skin.
        shown: Names of the layers that are shown; ``tactile_widgets.views.layers`` lists all.
    """

    base: BaseLayer = BaseLayer.PRESSURE
    shown: frozenset[str] = frozenset()

    def shows(self, name: str) -> bool:
        """Return whether the layer of this name is shown."""
        return name in self.shown

    def toggled(self, name: str) -> OverlayOptions:
        """Return the options with the visibility of one layer toggled."""
        return OverlayOptions(self.base, self.shown ^ {name})

    def to_text(self) -> str:
        """Return text for the settings file: the base layer and the layers that are shown."""
        return " ".join([self.base.value, *sorted(self.shown)])

    @classmethod
    def from_text(cls, text: str) -> OverlayOptions | None:
        """Parse the text of the settings file; return None if its base layer is unknown."""
        base, *shown = text.split() or [""]
        if base not in [known.value for known in BaseLayer]:
            return None
        return cls(BaseLayer(base), frozenset(shown))


class NavigationStyle(Enum):
    """Mouse buttons that move the camera, like those of another program."""

    STANDARD = "standard"
    MUJOCO = "mujoco"
    BLENDER = "blender"


FRAME_RATES = (60, 30, 15, 10)
"""Maxima of pictures per second that can be chosen."""


class Question(Enum):
    """Questions that the user can switch off: what they ask about can be undone."""

    IMPORT = "import"
    RESTORE = "restore"
    TRASH = "trash"


@dataclass(frozen=True)
class Preferences:
    """Choices of the dialog Preferences.

    Attributes:
        recordings: Folder of new recordings; empty for the default.
        theme: ``dark`` or ``light``.
        navigation: Mouse buttons that move the camera.
        frame_rate: Maximum number of pictures of the robot view per second.
        radians: Whether the panel Posture shows radians instead of degrees.
        unasked: Questions that are switched off.
    """

    recordings: str = ""
    theme: str = "dark"
    navigation: NavigationStyle = NavigationStyle.STANDARD
    frame_rate: int = FRAME_RATES[0]
    radians: bool = False
    unasked: frozenset[Question] = frozenset()

    def asks(self, question: Question) -> bool:
        """Whether a question is asked."""
        return question not in self.unasked


@dataclass(frozen=True)
class WindowLayout:
    """Arrangement of the window.

    Attributes:
        undocked: Names of the panels in their own windows.
        folded: Names of the folded panels.
        state: State of the docks and tool bars of Qt.
        plots: Plots that are shown, in the format of ``PlotChoice``; empty for those chosen by controller.
        views: Names of added views: ``second``, ``inset``.
    """

    undocked: tuple[str, ...]
    folded: tuple[str, ...]
    state: QByteArray
    plots: str = ""
    views: tuple[str, ...] = ()


_LAYOUT_NOW = "layout"
_LAYOUTS = "layouts"
_KEYS = "keys"
_RECENT = 8
_PACKAGE_ROOTS = 8


def _remove(store: QSettings, folder: Path) -> None:
    store.sync()  # a later write would create the folder again
    shutil.rmtree(folder, ignore_errors=True)


def usual_recordings_folder() -> Path:
    """Return the folder of recordings without another one in the preferences."""
    return user_documents_path() / "Tactile Maps"


class Settings:
    """Theme, geometry, overlays, keys, recent files and other settings of the window.

    Args:
        path: The INI file; by default the user's own.

    Attributes:
        own_folder: Folder of the file.
    """

    def __init__(self, path: Path | None = None) -> None:
        file = path or user_config_path("tactile-maps", appauthor=False) / "window.ini"
        self._store = QSettings(str(file), QSettings.Format.IniFormat)
        self.own_folder = file.parent

    @classmethod
    def temporary(cls) -> Settings:
        """Return settings that are removed with this object.

        They need a regular file: Qt replaces any other, so that ``os.devnull`` would be overwritten as root.
        """
        folder = Path(tempfile.mkdtemp(prefix="tactile-maps-settings-"))
        settings = cls(folder / "window.ini")
        weakref.finalize(settings, _remove, settings._store, folder)
        return settings

    @property
    def theme(self) -> str:
        """``dark`` or ``light``."""
        value = self._store.value("theme", "dark")
        return value if value in ("dark", "light") else "dark"

    @theme.setter
    def theme(self, name: str) -> None:
        self._store.setValue("theme", name)

    @property
    def recordings_folder(self) -> Path:
        """Folder of new recordings: the one in the preferences, or the usual one."""
        return Path(self.preferences.recordings or usual_recordings_folder())

    @property
    def documents_folder(self) -> Path:
        """Folder of the user's documents."""
        return usual_recordings_folder().parent

    @property
    def preferences(self) -> Preferences:
        """Choices of the dialog Preferences; unknown values are ignored."""
        store = self._store
        style = str(store.value("navigation", ""))
        rate = str(store.value("frame_rate", ""))
        unasked = str(store.value("unasked", "")).split()
        standard = Preferences()
        return Preferences(
            str(store.value("recordings", "")),
            self.theme,
            next((known for known in NavigationStyle if known.value == style), standard.navigation),
            int(rate) if rate in map(str, FRAME_RATES) else standard.frame_rate,
            str(store.value("radians", "false")).lower() == "true",
            frozenset(question for question in Question if question.value in unasked),
        )

    @preferences.setter
    def preferences(self, chosen: Preferences) -> None:
        self.theme = chosen.theme
        self._store.setValue("recordings", chosen.recordings)
        self._store.setValue("navigation", chosen.navigation.value)
        self._store.setValue("frame_rate", str(chosen.frame_rate))
        self._store.setValue("radians", "true" if chosen.radians else "false")
        self._store.setValue("unasked", " ".join(sorted(question.value for question in chosen.unasked)))

    @property
    def hints_read(self) -> bool:
        """True if the first hints are not shown again."""
        return str(self._store.value("hints_read", "false")).lower() == "true"

    @hints_read.setter
    def hints_read(self, read: bool) -> None:
        self._store.setValue("hints_read", "true" if read else "false")

    @property
    def recorded_for_viewers(self) -> bool:
        """True if recordings contain the messages for viewers of other programs."""
        return str(self._store.value("recorded_for_viewers", "true")).lower() == "true"

    @recorded_for_viewers.setter
    def recorded_for_viewers(self, on: bool) -> None:
        self._store.setValue("recorded_for_viewers", "true" if on else "false")

    @property
    def whole_recording(self) -> bool:
        """True if a replay shows the curves of the whole recording instead of the last seconds."""
        return str(self._store.value("whole_recording", "true")).lower() == "true"

    @whole_recording.setter
    def whole_recording(self, on: bool) -> None:
        self._store.setValue("whole_recording", "true" if on else "false")

    @property
    def keys(self) -> dict[str, tuple[str, ...]]:
        """Keys that replace the default ones, by name of the action; an empty tuple means no key."""
        self._store.beginGroup(_KEYS)
        names = self._store.childKeys()
        self._store.endGroup()
        return {name: tuple(str(self._store.value(f"{_KEYS}/{name}", "")).split()) for name in names}

    @keys.setter
    def keys(self, keys: Mapping[str, tuple[str, ...]]) -> None:
        self._store.remove(_KEYS)
        for name, chosen in keys.items():
            self._store.setValue(f"{_KEYS}/{name}", " ".join(chosen))

    @property
    def recent(self) -> list[str]:
        """Recently opened files, newest first."""
        value = self._store.value("recent", [])
        return [value] if isinstance(value, str) else [str(item) for item in value] if isinstance(value, list) else []

    def add_recent(self, path: str) -> None:
        """Add a file as the most recent one."""
        self._store.setValue("recent", [path, *(item for item in self.recent if item != path)][:_RECENT])

    def folder(self, kind: str) -> str:
        """Return the folder in which a file of this kind was last chosen; empty if never."""
        return str(self._store.value(f"folders/{kind}", ""))

    def set_folder(self, kind: str, folder: str) -> None:
        """Store the folder in which a file of this kind was chosen."""
        self._store.setValue(f"folders/{kind}", folder)

    def name_for(self, title: str, default: str) -> str:
        """Return the name that was last chosen instead of a default name; empty if never."""
        return str(self._store.value(f"names/{_key(title + default)}", ""))

    def set_name(self, title: str, default: str, name: str) -> None:
        """Store the name that was chosen instead of a default name."""
        self._store.setValue(f"names/{_key(title + default)}", name)

    @property
    def package_roots(self) -> tuple[str, ...]:
        """Folders in which robot files may find packages and meshes, newest first."""
        value = self._store.value("package_roots", [])
        return (value,) if isinstance(value, str) else tuple(map(str, value)) if isinstance(value, list) else ()

    def add_package_root(self, path: str) -> None:
        """Add a folder as the newest one."""
        roots = [path, *(root for root in self.package_roots if root != path)]
        self._store.setValue("package_roots", roots[:_PACKAGE_ROOTS])

    @property
    def source(self) -> tuple[str, str]:
        """Kind and address of the last source of readings, as entered in *Connect*; empty before the first."""
        return str(self._store.value("source/kind", "")), str(self._store.value("source/address", ""))

    @source.setter
    def source(self, source: tuple[str, str]) -> None:
        kind, address = source
        self._store.setValue("source/kind", kind)
        self._store.setValue("source/address", address)

    @property
    def overlays(self) -> OverlayOptions | None:
        """Setting of View > Overlay; None if never chosen."""
        return OverlayOptions.from_text(str(self._store.value("overlays", "")))

    @overlays.setter
    def overlays(self, overlays: OverlayOptions) -> None:
        self._store.setValue("overlays", overlays.to_text())

    @property
    def folded(self) -> tuple[str, ...] | None:
        """Names of the folded panels; None if never chosen."""
        value = self._store.value("folded")
        return None if value is None else tuple(str(value).split())

    @folded.setter
    def folded(self, names: tuple[str, ...]) -> None:
        self._store.setValue("folded", " ".join(names))

    @property
    def tab(self) -> str:
        """Tab of the panels that was shown last; empty if never chosen."""
        return str(self._store.value("tab", ""))

    @tab.setter
    def tab(self, name: str) -> None:
        self._store.setValue("tab", name)

    @property
    def figure(self) -> str:
        """Part, size, resolution and colours of the last figure; empty before the first."""
        return str(self._store.value("figure", ""))

    @figure.setter
    def figure(self, choice: str) -> None:
        self._store.setValue("figure", choice)

    @property
    def plots(self) -> str:
        """Plots that are shown, in the format of ``PlotChoice``; empty if never chosen."""
        return str(self._store.value("plots", ""))

    @plots.setter
    def plots(self, choice: str) -> None:
        self._store.setValue("plots", choice)

    @property
    def layout(self) -> WindowLayout | None:
        """Layout of the window when it was last closed; None before."""
        return self._read_layout(_LAYOUT_NOW)

    @layout.setter
    def layout(self, layout: WindowLayout) -> None:
        self._write_layout(_LAYOUT_NOW, layout)

    @property
    def layouts(self) -> dict[str, WindowLayout]:
        """Saved layouts, by name."""
        value = self._store.value("layout_names", [])
        names = [value] if isinstance(value, str) else [str(name) for name in value] if isinstance(value, list) else []
        found = {name: self._read_layout(f"{_LAYOUTS}/{_key(name)}") for name in names}
        return {name: layout for name, layout in found.items() if layout is not None}

    def save_layout(self, name: str, layout: WindowLayout) -> None:
        """Save a layout under a name; replaces a layout of that name."""
        names = [known for known in self.layouts if known != name]
        self._write_layout(f"{_LAYOUTS}/{_key(name)}", layout)
        self._store.setValue("layout_names", [*names, name])

    def delete_layout(self, name: str) -> None:
        """Delete a saved layout."""
        self._store.setValue("layout_names", [known for known in self.layouts if known != name])
        self._store.remove(f"{_LAYOUTS}/{_key(name)}")

    def _read_layout(self, key: str) -> WindowLayout | None:
        state = self._store.value(f"{key}/state")
        if not isinstance(state, QByteArray):
            return None
        undocked, folded, views = (
            tuple(str(self._store.value(f"{key}/{part}", "")).split()) for part in ("undocked", "folded", "views")
        )
        return WindowLayout(undocked, folded, state, str(self._store.value(f"{key}/plots", "")), views)

    def _write_layout(self, key: str, layout: WindowLayout) -> None:
        self._store.setValue(f"{key}/state", layout.state)
        self._store.setValue(f"{key}/undocked", " ".join(layout.undocked))
        self._store.setValue(f"{key}/folded", " ".join(layout.folded))
        self._store.setValue(f"{key}/plots", layout.plots)
        self._store.setValue(f"{key}/views", " ".join(layout.views))

    @property
    def geometry(self) -> QByteArray | None:
        """Geometry of the window when it was last closed; None before."""
        value = self._store.value("geometry")
        return value if isinstance(value, QByteArray) and not value.isEmpty() else None

    @geometry.setter
    def geometry(self, shape: QByteArray) -> None:
        self._store.setValue("geometry", shape)


def _key(name: str) -> str:
    """Return a name as a key of the settings file, in which a slash would separate groups."""
    return name.encode("utf8").hex()
