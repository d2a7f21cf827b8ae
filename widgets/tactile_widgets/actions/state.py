"""The state of the window on which depends what a person may ask of it: one immutable value, and rules about it."""

from __future__ import annotations

from dataclasses import dataclass, field

from tactile_maps.control.controller_registry import has_task
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.settings import OverlayOptions
from tactile_widgets.common.tool_kinds import POKE, ToolKind


@dataclass(frozen=True)
class UndoState:
    """What can be undone and redone.

    Attributes:
        can_undo: Whether there is anything to undo.
        can_redo: Whether there is anything to redo.
        undo_name: What would be undone; empty where that has no name.
        redo_name: What would be redone; empty where that has no name.
    """

    can_undo: bool = False
    can_redo: bool = False
    undo_name: str = ""
    redo_name: str = ""


@dataclass(frozen=True)
class WindowState:
    """What menus, toolbar and keys depend on; it changes with acts of a person, never with frames.

    Attributes:
        mode: Of the session.
        playing: Whether time passes, in the session or in a replay.
        recording: Whether a recording is being written.
        recorded_for_viewers: Whether recordings hold what viewers of other programs show.
        shared_with: Whose viewers see what is shown; empty for none.
        controller: Name of the one in force.
        task: Name of the one in force.
        path_kind: How the next path is drawn.
        can_control: Whether there is an arm to control, and a map to draw on.
        can_pose: Whether there is a simulated robot that can be led to a posture.
        can_undo_posture: Whether another posture was wanted before.
        has_path: Whether a path or a target was drawn.
        can_restart_task: Whether the task can start from its beginning.
        editable: Whether there is a map that takes edits.
        restorable: Whether a crash left edits of the map.
        edit_busy: Whether an edit is being computed.
        patches_selected: Whether there is a patch to edit.
        tool: In use.
        undo: Of what the tool is about.
        overlays: What View > Overlay is set to.
        light: Whether the light theme is in force.
        bodies_hidden: Whether links or objects are left out of the robot view.
        measured: Whether readings of a real skin are shown instead of a simulation.
        notable: Whether something can be said of the recording that is shown.
        has_marks: Whether moments of the recording are marked.
        has_episodes: Whether it has episodes.
        has_range: Whether a part of the recording is chosen.
        overlaid: Whether a second recording is drawn over it.
        can_repeat: Whether the touches of the recording can be repeated in a scene that runs behind it.
        looping: Whether that part is played again and again.
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
    edit_busy: bool = False
    patches_selected: bool = False
    tool: ToolKind = POKE
    undo: UndoState = UndoState()
    overlays: OverlayOptions = field(default_factory=OverlayOptions)
    light: bool = False
    bodies_hidden: bool = False
    measured: bool = False
    notable: bool = False
    has_marks: bool = False
    has_episodes: bool = False
    has_range: bool = False
    overlaid: bool = False
    can_repeat: bool = False
    looping: bool = False


def always(_state: WindowState) -> bool:
    """Nothing is needed."""
    return True


def has_scene(state: WindowState) -> bool:
    """Something is shown, live or replayed."""
    return state.mode is not Mode.EMPTY


def measured(state: WindowState) -> bool:
    """Readings of a real skin are shown."""
    return state.measured


def running(state: WindowState) -> bool:
    """A session is shown, running or paused."""
    return state.mode.takes_input


def simulating(state: WindowState) -> bool:
    """A simulation is shown, running or paused."""
    return state.mode.takes_input and not state.measured


def replaying(state: WindowState) -> bool:
    """A recording is shown."""
    return state.mode is Mode.REPLAYING


def overlaid(state: WindowState) -> bool:
    """A second recording is drawn over the one that is shown."""
    return state.overlaid


def can_mark(state: WindowState) -> bool:
    """A moment can be marked: of what is recorded, or of what is replayed."""
    return state.recording or state.notable


def paused(state: WindowState) -> bool:
    """A session is shown that stands still."""
    return state.mode is Mode.PAUSED


def editable(state: WindowState) -> bool:
    """There is a map that takes edits."""
    return state.editable


def restorable(state: WindowState) -> bool:
    """A crash left edits of the map, which can be restored now."""
    return state.editable and state.restorable


def patches_selected(state: WindowState) -> bool:
    """There are patches to edit."""
    return state.editable and state.patches_selected


def can_control(state: WindowState) -> bool:
    """There is an arm to control, and a map to draw on."""
    return state.can_control


def can_pose(state: WindowState) -> bool:
    """There is a simulated robot that can be led to a posture."""
    return state.can_pose


def has_tasks(state: WindowState) -> bool:
    """The controller in force does tasks."""
    return state.mode.takes_input and has_task(state.controller)
