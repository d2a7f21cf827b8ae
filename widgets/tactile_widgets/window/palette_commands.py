"""Commands of the palette: all actions, panels and their settings, scenes, robots and recent files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QAbstractSlider, QAbstractSpinBox, QComboBox, QMenu, QWidget

from tactile_widgets.actions.mnemonics import without_mnemonic
from tactile_widgets.actions.registry import ActionRegistry, ActionSpec, Menu, key_text
from tactile_widgets.common.panel import Panel
from tactile_widgets.dialogs.palette import Command
from tactile_widgets.panels.panel_column import PanelColumn

ListFiller = Callable[[QMenu], None]
_LISTS = {
    "scenes": "Open scene",
    "robots": "Open robot",
    "recent": "Open recent",
    "bodies": "Frame link",
    "coverable": "Cover link",
    "covered": "Remove skin of link",
    "findings": "Findings",
}
_CONTROLS = (QComboBox, QAbstractSpinBox, QAbstractSlider)


def action_commands(actions: ActionRegistry) -> list[Command]:
    """Return commands for all actions, with menu, first shortcut and tool tip."""
    paths = dict(_paths(actions.menus, ""))
    return [
        Command(
            f"{paths.get(spec.name, 'Remedy')} > {without_mnemonic(actions[spec.name].text())}".rstrip("…"),
            actions[spec.name].trigger,
            key_text(keys[0]) if (keys := actions.keys(spec.name)) else "",
            actions[spec.name].toolTip(),
            actions[spec.name].isEnabled(),
        )
        for spec in actions.specs
    ]


def _paths(menus: Sequence[Menu], above: str) -> Iterator[tuple[str, str]]:
    """Yield name and menu path of each action."""
    for menu in menus:
        path = f"{above} > {menu.title}" if above else menu.title
        for item in menu.items:
            if isinstance(item, Menu):
                yield from _paths([item], path)
            elif isinstance(item, ActionSpec):
                yield item.name, path


def listed_commands(menus: Mapping[str, QMenu], lists: Mapping[str, ListFiller]) -> list[Command]:
    """Return commands for scenes, robots and other listed entries, filled into ``menus``."""
    commands = []
    for name, heading in _LISTS.items():
        lists[name](menus[name])
        commands += [
            Command(
                f"{heading} > {without_mnemonic(entry.text())}",
                entry.trigger,
                tip=entry.toolTip(),
                enabled=entry.isEnabled(),
            )
            for entry in menus[name].actions()
        ]
    return commands


def panel_commands(column: PanelColumn, show: Callable[[], None]) -> list[Command]:
    """Return commands that show each panel; see ``setting_commands`` for the parameters."""
    return [
        Command(f"Panel > {panel.accessibleName()}", partial(_reveal, column, panel, show), words=panel.search_words)
        for panel in column
        if not panel.isHidden()
    ]


def setting_commands(column: PanelColumn, show: Callable[[], None]) -> list[Command]:
    """Return commands that show and focus the drop-downs, sliders and number fields of the panels.

    Args:
        column: Column of the panels.
        show: Shows the column.
    """
    commands = []
    seen = set[tuple[str, str]]()
    for panel in column.findChildren(Panel):
        for control in (found for kind in _CONTROLS for found in panel.findChildren(kind)):
            name = control.accessibleName().split("\n")[0]
            heading = panel.accessibleName()
            if name and (heading, name) not in seen and not control.isHidden():
                seen.add((heading, name))
                run = partial(_focus, column, panel, control, show)
                text = f"Setting > {heading} > {name.split(':')[0]}"
                around = control.parentWidget()  # the parent of a slider is hidden with it
                enabled = control.isEnabled() and not (around is not None and around.isHidden())
                commands.append(Command(text, run, tip=control.toolTip(), enabled=enabled))
    return commands


def _reveal(column: PanelColumn, panel: Panel, show: Callable[[], None]) -> None:
    show()
    column.reveal(panel)


def _focus(column: PanelColumn, panel: Panel, control: QWidget, show: Callable[[], None]) -> None:
    show()
    column.reveal(panel, control)
    control.setFocus(Qt.FocusReason.ShortcutFocusReason)
