"""Table of actions: unique names and keys, and the rules that enable and check them."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import product

import pytest

from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.editing.arrange import EDGES
from tactile_widgets.actions.keymap import RESERVED
from tactile_widgets.actions.registry import key_rows, key_text, specs_in, taken_by_menus
from tactile_widgets.actions.state import UndoState, WindowState
from tactile_widgets.actions.table import REMEDIES, menu_bar, mouse_gestures, tool_action
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.settings import NavigationStyle, OverlayOptions
from tactile_widgets.common.tool_kinds import ToolKind, ToolRole
from tactile_widgets.tools.registry import ARRANGE, PATH, TOOLS, ToolSpec
from tactile_widgets.views.layers import LAYERS, LayerSpec, at_first

SPECS = {spec.name: spec for spec in (*specs_in(menu_bar()), *REMEDIES)}


def states():
    """Yield states of all modes and tools, with all bools equal, or one different."""
    switches = [field.name for field in fields(WindowState) if field.type == "bool"]
    undo = UndoState(can_undo=True, can_redo=True, undo_name="Move", redo_name="Pin")
    for mode, on, tool in product(Mode, (False, True), (spec.kind for spec in TOOLS)):
        state = replace(WindowState(), mode=mode, tool=tool, undo=undo, **dict.fromkeys(switches, on))
        yield state
        for name in switches:
            yield replace(state, **{name: not on})


def test_each_action_is_in_one_menu_or_a_remedy():
    names = [spec.name for spec in (*specs_in(menu_bar()), *REMEDIES)]
    assert len(names) == len(set(names)) > 80
    assert not {spec.name for spec in REMEDIES} & {spec.name for spec in specs_in(menu_bar())}


def test_default_keys_are_unique_and_not_reserved():
    keys = [key for spec in SPECS.values() for key in spec.keys]
    assert len(keys) == len(set(keys))
    assert not set(keys) & (RESERVED.keys() | taken_by_menus(menu_bar()).keys()), "and none is reserved"


@pytest.mark.long
def test_every_rule_returns_a_bool_in_every_state():
    count = 0
    for state in states():
        for spec in SPECS.values():
            assert isinstance(spec.enabled(state), bool), spec.name
            assert spec.checked is None or isinstance(spec.checked(state), bool), spec.name
            assert spec.text_for is None or spec.text_for(state)
            assert spec.icon_for is None or spec.icon_for(state)
            count += 1
    assert count > 10_000


def enabled(state):
    return {name for name, spec in SPECS.items() if spec.enabled(state)}


def test_empty_window_enables_opening():
    names = enabled(WindowState())
    assert {"open_robot", "open_recording", "theme", "quit", "poke", "keys"} <= names
    assert not names & {"pause", "step", "reset", "record", "save", "undo", "weigh", "compare_controllers"}
    assert not names & {"arrange", "draw_path", "more_force", "save_scene", "controller_hybrid", "task_follow_path"}


def test_step_is_enabled_only_while_paused():
    of = {mode: enabled(WindowState(mode=mode)) for mode in Mode}
    assert [mode for mode in Mode if "step" in of[mode]] == [Mode.PAUSED]
    assert [mode for mode in Mode if "pause" in of[mode]] == [Mode.RUNNING, Mode.PAUSED, Mode.REPLAYING]
    assert [mode for mode in Mode if "record" in of[mode]] == [Mode.RUNNING, Mode.PAUSED]
    assert [mode for mode in Mode if "save_scene" in of[mode]] == [Mode.RUNNING, Mode.PAUSED, Mode.REPLAYING]


def test_replay_disables_changes_of_the_session():
    names = enabled(replace(WindowState(mode=Mode.REPLAYING), controller="hybrid", can_restart_task=True))
    assert not any(name.startswith(("controller_", "task_")) for name in names)
    assert not names & {"reset", "record", "reset_gains", "start_again", "weigh", "save_script", "play_script"}


def test_tasks_are_enabled_for_controllers_with_tasks():
    for controller in ("hold_force", *CONTROL_SCHEMES):
        names = enabled(WindowState(mode=Mode.RUNNING, controller=controller))
        assert ("task_follow_path" in names) == (controller in CONTROL_SCHEMES)


def test_arranging_needs_selected_patches():
    some = {"mirror", "true_size", "hide_patches", *(f"align_{edge}" for edge in EDGES)}
    assert not enabled(WindowState(editable=True)) & some
    assert enabled(WindowState(editable=True, patches_selected=True)) >= some
    assert not enabled(WindowState(patches_selected=True)) & some


def test_current_choices_are_checked():
    state = WindowState(controller="qp", task="follow_path", path_kind="spline", tool=PATH, recording=True)
    down = {name for name, spec in SPECS.items() if spec.checked is not None and spec.checked(state)}
    assert {"controller_qp", "task_follow_path", "path_spline", "draw_path", "record", "ground_pressure"} <= down
    assert "arrange" not in down
    assert SPECS["arrange"].checked(replace(state, tool=ARRANGE))


def test_tool_is_defined_in_one_line():
    """Its action, key, button and menu come from its spec."""
    ruler = ToolSpec(ToolKind("ruler", ToolRole.EDIT), "Ruler", "Y", "Measure the map")
    (edit,) = [menu for menu in menu_bar((*TOOLS, ruler)) if menu.title == "Edit"]
    action = next(item for item in edit.items if getattr(item, "name", "") == "ruler")
    assert action.keys == tool_action(ruler).keys == ("Y",)
    assert action.toolbar == "edit"
    assert action.checked(WindowState(tool=ruler.kind))
    assert not action.enabled(WindowState())


def test_layer_is_defined_in_one_line():
    """Its action and key come from its spec."""
    grid = LayerSpec("grid", "Grid", "Alt+G", "Show a grid")
    (view,) = [menu for menu in menu_bar(layers=(*LAYERS, grid)) if menu.title == "View"]
    action = next(spec for spec in specs_in([view]) if spec.name == "mark_grid")
    assert action.keys == ("Alt+G",)
    assert not action.checked(WindowState())
    assert action.checked(WindowState(overlays=OverlayOptions().toggled("grid")))


def test_layers_define_whether_they_are_shown_at_first():
    hidden = LayerSpec("grid", "Grid", "", "Show a grid")
    shown = LayerSpec("frame", "Frame", "", "Show a frame", shown_at_first=True)
    assert at_first((hidden, shown)).shown == {"frame"}


def test_key_list_contains_every_action_with_a_tip():
    assert key_text("Alt+Up") == "Alt+↑"
    listed = {name: words for _, rows in key_rows(menu_bar()) for name, words in rows}
    assert listed == {spec.name: spec.text.rstrip("…") for spec in specs_in(menu_bar())}
    assert "turn the view" in mouse_gestures(NavigationStyle.STANDARD)[0][1], "the most frequent gesture"
    assert all(spec.tip for spec in SPECS.values()), "every action has a tool tip"
