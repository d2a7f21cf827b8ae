"""The state of the window that enables and checks actions, as one immutable value, and rules about it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from operator import attrgetter

from tactile_maps.control.controller_registry import has_task
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.settings import OverlayOptions
from tactile_widgets.common.tool_kinds import POKE, ToolKind


@dataclass(frozen=True)
class UndoState:
    """Undo and redo.

    Attributes:
        can_undo: Whether a step can be undone.
        can_redo: Whether a step can be redone.
        undo_name: Name of the step to undo; may be empty.
        redo_name: Name of the step to redo; may be empty.
    """

    can_undo: bool = False
    can_redo: bool = False
    undo_name: str = ""
    redo_name: str = ""


@dataclass(frozen=True)
class WindowState:
    """State that menus, toolbar and keys depend on. It changes by actions of the user, never with ticks.

    Attributes:
        mode: Mode of the session.
        playing: Whether time advances, in the session or in a replay.
        recording: Whether a recording is being written.
        shared_with: Program whose viewers show the session; empty if there is none.
        recorded_for_viewers: Whether recordings hold what viewers of other programs show.
        controller: Name of the current controller.
        task: Name of the current task.
        path_kind: Shape of the next path.
        can_control: Whether an arm can be controlled and a path drawn on its map.
        can_pose: Whether a simulated robot can be moved to a posture.
        can_undo_posture: Whether there is a previous target posture.
        has_path: Whether a path or a target was drawn.
        can_restart_task: Whether the task can restart from its beginning.
        editable: Whether a map is shown that can be edited.
        restorable: Whether a crash left edits of the map.
        unsaved_elsewhere: Whether a crash left edits of another document.
        edit_busy: Whether an edit is being computed.
        patches_selected: Whether patches are selected.
        tool: Current tool.
        undo: Undo and redo of edits.
        overlays: Settings of View > Overlay.
        light: Whether the light theme is used.
        bodies_hidden: Whether links or objects are hidden in the robot view.
        measured: Whether readings of a real skin are shown instead of a simulation.
        measured_recording: Whether the recording that is shown has readings of a real skin.
        notable: Whether notes on the shown recording can be edited.
        has_marks: Whether the recording has marks.
        has_episodes: Whether the recording has episodes.
        has_range: Whether a range of the recording is chosen.
        overlaid: Whether a second recording is drawn over it.
        can_repeat: Whether the touches of the recording can be repeated in the scene that runs behind it.
        looping: Whether the range is played repeatedly.
        has_script: Whether the scene has a stimulus script.
        script_repeats: Whether that script is repeated.
    """

    mode: Mode = Mode.EMPTY
    playing: bool = False
    recording: bool = False
    shared_with: str = ""
    recorded_for_viewers: bool = True
    controller: str = ""
    task: str = ""
    path_kind: str = ""
    can_control: bool = False
    can_pose: bool = False
    can_undo_posture: bool = False
    has_path: bool = False
    can_restart_task: bool = False
    editable: bool = False
    restorable: bool = False
    unsaved_elsewhere: bool = False
    edit_busy: bool = False
    patches_selected: bool = False
    tool: ToolKind = POKE
    undo: UndoState = UndoState()
    overlays: OverlayOptions = field(default_factory=OverlayOptions)
    light: bool = False
    bodies_hidden: bool = False
    measured: bool = False
    measured_recording: bool = False
    notable: bool = False
    has_marks: bool = False
    has_episodes: bool = False
    has_range: bool = False
    overlaid: bool = False
    can_repeat: bool = False
    looping: bool = False
    has_script: bool = False
    script_repeats: bool = True


StateRule = Callable[[WindowState], bool]
"""Rule that enables or checks an action."""


def always(_state: WindowState) -> bool:
    """Return True: the action is always enabled."""
    return True


def has_scene(state: WindowState) -> bool:
    """Whether a session or a recording is shown."""
    return state.mode is not Mode.EMPTY


def running(state: WindowState) -> bool:
    """Whether a session is shown, running or paused."""
    return state.mode.takes_input


def simulating(state: WindowState) -> bool:
    """Whether a simulation is shown, running or paused."""
    return running(state) and not state.measured


def scripted(state: WindowState) -> bool:
    """Whether a simulation of a scene with a stimulus script is shown."""
    return simulating(state) and state.has_script


def replaying(state: WindowState) -> bool:
    """Whether a recording is shown."""
    return state.mode is Mode.REPLAYING


def can_take_over(state: WindowState) -> bool:
    """Whether a simulation can continue the recording that is shown."""
    return replaying(state) and not state.measured_recording


def can_mark(state: WindowState) -> bool:
    """Whether a moment of the recording being made or shown can be marked."""
    return state.recording or state.notable


def paused(state: WindowState) -> bool:
    """Whether a paused session is shown."""
    return state.mode is Mode.PAUSED


def restorable(state: WindowState) -> bool:
    """Whether edits that a crash left can be restored now."""
    return state.editable and state.restorable


def unsaved_elsewhere(state: WindowState) -> bool:
    """Whether a crash left edits of another document."""
    return state.unsaved_elsewhere


def patches_selected(state: WindowState) -> bool:
    """Whether selected patches can be edited."""
    return state.editable and state.patches_selected


def has_tasks(state: WindowState) -> bool:
    """Whether the current controller has tasks."""
    return running(state) and has_task(state.controller)


measured: StateRule = attrgetter("measured")
overlaid: StateRule = attrgetter("overlaid")
editable: StateRule = attrgetter("editable")
can_control: StateRule = attrgetter("can_control")
can_pose: StateRule = attrgetter("can_pose")
has_marks: StateRule = attrgetter("has_marks")
has_range: StateRule = attrgetter("has_range")
