"""What the window remembers between launches, in one file a person can read; the overlay options among it.

``OverlayOptions`` is the setting of View > Overlay: one base layer under the touch, and marks on or off.
"""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from platformdirs import user_config_path
from PySide6.QtCore import QByteArray, QSettings


class BaseLayer(Enum):
    """What bare skin looks like; each value is the end of the name of the action that chooses it."""

    PRESSURE = "pressure"
    ANGLE = "angle"
    AREA = "area"
    CHECKER = "checker"
    CIRCLES = "circles"

    @property
    def title(self) -> str:
        """As in the legend."""
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
        ground: What bare skin looks like.
        shown: The layers that are shown, by name; ``tactile_widgets.views.layers`` lists them.
    """

    ground: BaseLayer = BaseLayer.PRESSURE
    shown: frozenset[str] = frozenset()

    def shows(self, name: str) -> bool:
        """Whether the layer of this name is shown."""
        return name in self.shown

    def toggled(self, name: str) -> OverlayOptions:
        """The same with one layer shown that was not, or hidden that was shown."""
        return OverlayOptions(self.ground, self.shown ^ {name})

    def to_text(self) -> str:
        """For the settings' file: the ground and the layers that are shown."""
        return " ".join([self.ground.value, *sorted(self.shown)])

    @classmethod
    def from_text(cls, text: str) -> OverlayOptions | None:
        """From the settings' file; None where that says nothing that is known."""
        ground, *shown = text.split() or [""]
        if ground not in [known.value for known in BaseLayer]:
            return None
        return cls(BaseLayer(ground), frozenset(shown))


@dataclass(frozen=True)
class WindowLayout:
    """How the window is arranged.

    Attributes:
        undocked: Names of the panels that stand in windows of their own.
        folded: Names of the panels of which only the heading shows.
        state: Of Qt's docks and bars.
        plots: Which plots are shown, as ``PlotChoice`` writes it; empty for those that the controller calls for.
        views: Names of the views that were added: ``second``, ``inset``.
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
    store.sync()  # else it would write after this
    shutil.rmtree(folder, ignore_errors=True)


class Settings:
    """Theme, window shape, overlays, keys, recent files, and whether the hints were read.

    Args:
        path: The INI file; by default the user's own.

    Attributes:
        own_folder: Contains the file.
    """

    def __init__(self, path: Path | None = None) -> None:
        file = path or user_config_path("tactile-maps", appauthor=False) / "window.ini"
        self._store = QSettings(str(file), QSettings.Format.IniFormat)
        self.own_folder = file.parent

    @classmethod
    def temporary(cls) -> Settings:
        """Return settings that are removed with this object.

        They are in a file: Qt replaces any other, so that as root ``os.devnull`` would become a regular file.
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
    def hints_read(self) -> bool:
        """Whether the first hints need not be shown again."""
        return str(self._store.value("hints_read", "false")).lower() == "true"

    @hints_read.setter
    def hints_read(self, read: bool) -> None:
        self._store.setValue("hints_read", "true" if read else "false")

    @property
    def recorded_for_viewers(self) -> bool:
        """Whether recordings hold what viewers of other programs show."""
        return str(self._store.value("recorded_for_viewers", "true")).lower() == "true"

    @recorded_for_viewers.setter
    def recorded_for_viewers(self, on: bool) -> None:
        self._store.setValue("recorded_for_viewers", "true" if on else "false")

    @property
    def whole_recording(self) -> bool:
        """Whether a replay shows the curves of the whole recording, not of the last seconds."""
        return str(self._store.value("whole_recording", "true")).lower() == "true"

    @whole_recording.setter
    def whole_recording(self, on: bool) -> None:
        self._store.setValue("whole_recording", "true" if on else "false")

    @property
    def keys(self) -> dict[str, tuple[str, ...]]:
        """The keys that were chosen instead of those an action comes with, by its name; empty for none at all."""
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
        """Files opened lately, newest first."""
        value = self._store.value("recent", [])
        return [value] if isinstance(value, str) else [str(item) for item in value] if isinstance(value, list) else []

    def add_recent(self, path: str) -> None:
        """Put a file on top of the recent ones."""
        self._store.setValue("recent", [path, *(item for item in self.recent if item != path)][:_RECENT])

    def folder(self, kind: str) -> str:
        """Where a file of this kind was last chosen; empty if never."""
        return str(self._store.value(f"folders/{kind}", ""))

    def set_folder(self, kind: str, folder: str) -> None:
        """Remember it."""
        self._store.setValue(f"folders/{kind}", folder)

    @property
    def package_roots(self) -> tuple[str, ...]:
        """Folders in which robot files may find packages and meshes, newest first."""
        value = self._store.value("package_roots", [])
        return (value,) if isinstance(value, str) else tuple(map(str, value)) if isinstance(value, list) else ()

    def add_package_root(self, path: str) -> None:
        """Put a folder before the others."""
        roots = [path, *(root for root in self.package_roots if root != path)]
        self._store.setValue("package_roots", roots[:_PACKAGE_ROOTS])

    @property
    def overlays(self) -> OverlayOptions | None:
        """What View > Overlay was set to; None if that was never chosen."""
        return OverlayOptions.from_text(str(self._store.value("overlays", "")))

    @overlays.setter
    def overlays(self, overlays: OverlayOptions) -> None:
        self._store.setValue("overlays", overlays.to_text())

    @property
    def folded(self) -> tuple[str, ...] | None:
        """The panels of which only the heading shows; None if that was never chosen."""
        value = self._store.value("folded")
        return None if value is None else tuple(str(value).split())

    @folded.setter
    def folded(self, names: tuple[str, ...]) -> None:
        self._store.setValue("folded", " ".join(names))

    @property
    def figure(self) -> str:
        """Part, size, resolution and colours of the last figure; empty before."""
        return str(self._store.value("figure", ""))

    @figure.setter
    def figure(self, choice: str) -> None:
        self._store.setValue("figure", choice)

    @property
    def plots(self) -> str:
        """Which plots are shown, as ``PlotChoice`` writes it; empty if that was never chosen."""
        return str(self._store.value("plots", ""))

    @plots.setter
    def plots(self, choice: str) -> None:
        self._store.setValue("plots", choice)

    @property
    def layout(self) -> WindowLayout | None:
        """The window's layout when it was last closed; None before."""
        return self._read_layout(_LAYOUT_NOW)

    @layout.setter
    def layout(self, layout: WindowLayout) -> None:
        self._write_layout(_LAYOUT_NOW, layout)

    @property
    def layouts(self) -> dict[str, WindowLayout]:
        """Those that were saved, by name."""
        value = self._store.value("layout_names", [])
        names = [value] if isinstance(value, str) else [str(name) for name in value] if isinstance(value, list) else []
        found = {name: self._read_layout(f"{_LAYOUTS}/{_key(name)}") for name in names}
        return {name: layout for name, layout in found.items() if layout is not None}

    def save_layout(self, name: str, layout: WindowLayout) -> None:
        """Keep a layout under a name, in place of one that had it."""
        names = [known for known in self.layouts if known != name]
        self._write_layout(f"{_LAYOUTS}/{_key(name)}", layout)
        self._store.setValue("layout_names", [*names, name])

    def delete_layout(self, name: str) -> None:
        """Forget it."""
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
        """The window's shape when it was last closed."""
        value = self._store.value("geometry")
        return value if isinstance(value, QByteArray) and not value.isEmpty() else None

    @geometry.setter
    def geometry(self, shape: QByteArray) -> None:
        self._store.setValue("geometry", shape)


def _key(name: str) -> str:
    """A name as a key of the settings' file, in which a slash would divide it."""
    return name.encode("utf8").hex()
