"""The menu bar as a table, with all actions, and the remedies that messages offer.

Every action is defined here only. Menus, toolbar, shortcuts, the list of keys, texts, enabling and check marks are made
from this table; presenters bind the handlers. Tools, overlays, controllers and tasks have tables of their own, from
which their actions are made here.
"""

from __future__ import annotations

from functools import partial
from operator import attrgetter
from typing import get_args

from tactile_maps.control.controller_registry import CONTROLLERS
from tactile_maps.editing.arrange import EDGES
from tactile_maps.maps.paths import PathKind
from tactile_widgets.actions.registry import LINE, ActionSpec, Menu, MenuList
from tactile_widgets.actions.state import (
    WindowState,
    always,
    can_control,
    can_mark,
    can_pose,
    can_take_over,
    editable,
    has_marks,
    has_range,
    has_scene,
    has_tasks,
    measured,
    overlaid,
    patches_selected,
    paused,
    replaying,
    restorable,
    running,
    scripted,
    simulating,
    unsaved_elsewhere,
)
from tactile_widgets.common.controller_settings import SETTING_CHOICES
from tactile_widgets.common.settings import BaseLayer, NavigationStyle
from tactile_widgets.common.tool_kinds import ToolRole
from tactile_widgets.tools.registry import TOOLS, ToolSpec
from tactile_widgets.views.layers import LAYERS, LayerSpec

_MEASURED = "Not for recordings of a real skin: no simulation continues its readings"
_TOOL_ENABLED = {ToolRole.EDIT: editable, ToolRole.CONTROL: can_control}
_PATHS = {
    "polyline": ("Polyline", "Straight lines between corners"),
    "spline": ("Spline", "Smooth curve through all corners"),
    "lemniscate": ("Figure of eight", "Dragged from end to end"),
    "raster": ("Raster", "Parallel lines over a box"),
}
_ALIGN = {
    "left": ("Left sides", "by their left sides"),
    "centre": ("Centres on a vertical line", "on a vertical line"),
    "right": ("Right sides", "by their right sides"),
    "top": ("Tops", "by their tops"),
    "middle": ("Centres on a horizontal line", "on a horizontal line"),
    "bottom": ("Bottoms", "by their bottoms"),
}
_BASE_LAYERS = {
    BaseLayer.PRESSURE: ("Pressure", "Show pressure only"),
    BaseLayer.ANGLE: (
        "Angle distortion",
        "Ratio of the larger to the smaller stretch at each point (1: no angle distortion)",
    ),
    BaseLayer.AREA: ("Area distortion", "Ratio of map area to body area at each point (1: no area distortion)"),
    BaseLayer.CHECKER: ("Checker", "Checkerboard on the map, shown on the body as the map distorts it"),
    BaseLayer.CIRCLES: ("Circles", "Circles on the body, shown on the map as ellipses (Tissot's indicatrix)"),
}


def tool_action(spec: ToolSpec) -> ActionSpec:
    """Return the action that selects a tool."""
    name = spec.kind.name
    return ActionSpec(
        name,
        spec.text,
        spec.key,
        spec.tip,
        _TOOL_ENABLED.get(spec.kind.role, always),
        checked=lambda state: state.tool.name == name,
        group="tool",
        icon=name,
        toolbar=spec.kind.role.value,
    )


def _tools(role: ToolRole, specs: tuple[ToolSpec, ...]) -> tuple[ActionSpec, ...]:
    return tuple(tool_action(spec) for spec in specs if spec.kind.role is role)


def _is(field: str, value: object, state: WindowState) -> bool:
    return bool(attrgetter(field)(state) == value)


def layer_action(spec: LayerSpec) -> ActionSpec:
    """Return the action that shows or hides a layer."""
    return ActionSpec(
        f"mark_{spec.name}", spec.text, spec.key, spec.tip, checked=lambda state: state.overlays.shows(spec.name)
    )


_PATH_ACTIONS = tuple(
    ActionSpec(
        f"path_{kind}",
        _PATHS[kind][0],
        "",
        _PATHS[kind][1],
        can_control,
        checked=partial(_is, "path_kind", kind),
        group="path",
    )
    for kind in get_args(PathKind)
)
_ALIGN_ACTIONS = tuple(
    ActionSpec(
        f"align_{edge}", _ALIGN[edge][0], "", f"Line up the selected patches {_ALIGN[edge][1]}", patches_selected
    )
    for edge in EDGES
)
_BASE_LAYER_ACTIONS = tuple(
    ActionSpec(
        f"ground_{layer.value}",
        _BASE_LAYERS[layer][0],
        f"Ctrl+{number}",
        _BASE_LAYERS[layer][1],
        checked=partial(_is, "overlays.base", layer),
        group="ground",
    )
    for number, layer in enumerate(BaseLayer, start=1)
)


def _with_name(verb: str, step: str) -> str:
    return f"{verb} {step[:1].lower()}{step[1:]}" if step else verb


_FILE = Menu(
    "File",
    (
        ActionSpec("open_robot", "Open robot…", "Ctrl+O", "Open MJCF, URDF, xacro or a bare mesh"),
        MenuList("robots", "Robots"),
        ActionSpec(
            "package_root",
            "Choose package root…",
            "",
            "Choose a folder with ROS packages or meshes that robot files name",
        ),
        MenuList("scenes", "Open scene"),
        ActionSpec("open_scene", "Open scene file…", "", "Open a scene file (.toml)"),
        ActionSpec(
            "import_taxels",
            "Import taxels…",
            "",
            "Place the taxels of one or several files (iCub, CSV, JSON, npz) on the robot",
        ),
        ActionSpec("open_recording", "Open recording…", "Ctrl+Shift+O", "Replay a recording"),
        ActionSpec(
            "recordings",
            "Recordings…",
            "Ctrl+Shift+R",
            "List the recordings of a folder with their pictures: replay, label, find or delete them",
        ),
        ActionSpec("open_study", "Open study table…", "", "Plot a table of tactile-maps study and see its rows"),
        MenuList("recent", "Recent files"),
        LINE,
        ActionSpec(
            "connect",
            "Connect…",
            "Ctrl+Shift+C",
            "Show readings of a real skin: UDP, ZeroMQ, serial, YARP, ROS 2 or a file",
            has_scene,
        ),
        ActionSpec("disconnect", "Disconnect", "", "Close the source and simulate again", measured),
        LINE,
        ActionSpec(
            "open_map",
            "Open map…",
            "Ctrl+L",
            "Apply a map of this skin: npz, OBJ with UV, or SVG",
            editable,
        ),
        ActionSpec(
            "save",
            "Save",
            "Ctrl+S",
            "Save what was changed: the map, and the scene with skin, path, controller, contact detection and effects",
            editable,
        ),
        ActionSpec("save_map_as", "Save map as…", "Ctrl+Shift+S", "Save the tactile map under another name", editable),
        ActionSpec(
            "export_map",
            "Export map…",
            "Ctrl+E",
            "Export for other programs: OBJ with UV, SVG, PNG, CSV and more",
            editable,
        ),
        Menu(
            "Edits after a crash",
            (
                ActionSpec(
                    "restore_map",
                    "Restore edits",
                    "",
                    "Restore the edits of this map that were not saved when the program ended",
                    restorable,
                ),
                ActionSpec(
                    "discard_restore",
                    "Discard edits…",
                    "",
                    "Delete the edits of this map that were not saved when the program ended",
                    restorable,
                ),
                ActionSpec(
                    "open_unsaved",
                    "Open document",
                    "",
                    "Open another document with edits that were not saved when the program ended, the newest first",
                    unsaved_elsewhere,
                ),
            ),
        ),
        LINE,
        ActionSpec(
            "save_scene", "Save scene as…", "", "Save skin, effects, contact detection, controller and path", has_scene
        ),
        LINE,
        ActionSpec(
            "export_recording",
            "Export recording…",
            "",
            "Write a recording for other programs: CSV, Parquet, HDF5, LeRobot, ROS 2, a film",
        ),
        ActionSpec(
            "share_live",
            "Share live",
            "",
            "Show the session in Foxglove and Lichtblick on this computer; other computers cannot connect",
            has_scene,
            checked=partial(_is, "shared_with", "Foxglove"),
        ),
        ActionSpec(
            "share_rerun",
            "Show live in Rerun",
            "",
            "Show the session in the Rerun viewer that is open on this computer",
            has_scene,
            checked=partial(_is, "shared_with", "Rerun"),
            needs="rerun",
            extra="rerun",
        ),
        LINE,
        ActionSpec(
            "copy_command",
            "Copy as command line",
            "Ctrl+Alt+C",
            "Copy the command line that opens what the window shows",
            has_scene,
        ),
        Menu(
            "Pictures and films",
            (
                ActionSpec(
                    "film",
                    "Film…",
                    "Ctrl+Alt+M",
                    "Film the recording shown, or record the session for a film: MP4 of body and map",
                    has_scene,
                    text_for=lambda state: "Stop and film…" if state.recording else "Film…",
                    needs="av",
                    extra="export",
                ),
                ActionSpec(
                    "film_file",
                    "Film a recording…",
                    "",
                    "Film a recording that is not shown",
                    needs="av",
                    extra="export",
                ),
                ActionSpec(
                    "save_figure",
                    "Save figure…",
                    "Ctrl+Alt+F",
                    "Save robot, map or plots for a paper: SVG, PDF or PNG at a stated size and resolution",
                ),
                ActionSpec("save_picture", "Save picture…", "Ctrl+Alt+P", "Save the window as a picture"),
            ),
        ),
        LINE,
        ActionSpec("quit", "Quit", "Ctrl+Q", "Close the window"),
    ),
)

_UNDO = (
    ActionSpec(
        "undo",
        "Undo",
        "Ctrl+Z",
        "Undo the last edit of map, skin, path, target, force or posture",
        attrgetter("undo.can_undo"),
        text_for=lambda state: _with_name("Undo", state.undo.undo_name),
        icon="undo",
        toolbar="undo",
    ),
    ActionSpec(
        "redo",
        "Redo",
        "Ctrl+Shift+Z Ctrl+Y",
        "Redo the last undone edit",
        attrgetter("undo.can_redo"),
        text_for=lambda state: _with_name("Redo", state.undo.redo_name),
        icon="redo",
        toolbar="undo",
    ),
)

_MAP_EDITS = (
    ActionSpec("add_pin", "Pin", "P", "Pin the place under the pointer, or the selected taxels", editable),
    ActionSpec("remove_pin", "Remove pins", "Alt+P", "Remove the selected pins, or the nearest", editable),
    ActionSpec("select_pins", "Select pins", "Shift+P", "Select all pins of the selected patches", editable),
    LINE,
    ActionSpec(
        "propose_seam",
        "Propose a seam",
        "Ctrl+K",
        "Propose the seam that reduces distortion most, and show by how much",
        editable,
    ),
    ActionSpec("mirror", "Mirror", "Ctrl+M", "Mirror the selected patches horizontally", patches_selected),
    Menu("Align", (*_ALIGN_ACTIONS[:3], LINE, *_ALIGN_ACTIONS[3:])),
    ActionSpec("true_size", "True size", "", "Reset the scale of the selected patches to 1", patches_selected),
    ActionSpec(
        "repack",
        "Repack",
        "Ctrl+Shift+K",
        "Arrange all patches, or those selected, as they are located on the body",
        editable,
    ),
    LINE,
    ActionSpec(
        "hide_patches", "Hide patches", "H", "Hide the selected patches; hidden patches keep sensing", patches_selected
    ),
    ActionSpec("show_patches", "Show all patches", "Alt+H", "Show every patch", editable),
    LINE,
    ActionSpec(
        "choose_skin",
        "Skin: cover links with taxels…",
        "",
        "Choose the links that the skin covers, and number, pattern and margin of its taxels",
    ),
    MenuList("coverable", "Cover link"),
    MenuList("covered", "Remove skin of link"),
    LINE,
    ActionSpec("cancel_edit", "Cancel the edit", "Ctrl+.", "Cancel the running edit", attrgetter("edit_busy")),
)

_PREFERENCES = ActionSpec(
    "preferences",
    "Preferences…",
    "Ctrl+,",
    "Choose folder of recordings, theme, mouse buttons, frame rate, units of angles, and questions",
)

_SESSION = Menu(
    "Session",
    (
        ActionSpec(
            "pause",
            "Pause",
            "Space",
            "Pause or resume the session; in a replay, play or pause",
            has_scene,
            yields=True,
            text_for=lambda state: "Pause" if state.playing else "Play",
            icon_for=lambda state: "pause" if state.playing else "play",
            toolbar="session",
        ),
        ActionSpec(
            "step",
            "Step",
            ".",
            "Advance one control tick while paused, also by →",
            paused,
            icon="step",
            toolbar="session",
        ),
        ActionSpec(
            "reset", "Reset", "Backspace", "Restart the scene", running, yields=True, icon="reset", toolbar="session"
        ),
        ActionSpec(
            "back_to_live",
            "Back to live",
            "",
            "Leave the recording and go back to the running simulation",
            replaying,
        ),
        ActionSpec(
            "take_over",
            "Take over from here",
            "",
            "Continue the simulation from the instant of the recording that is shown",
            can_take_over,
            refusal_for=lambda state: _MEASURED if state.measured_recording else "",
        ),
    ),
)

_RECORDING = Menu(
    "Recording",
    (
        ActionSpec(
            "record",
            "Record",
            "Ctrl+R",
            "Record every tick to a file",
            running,
            checked=attrgetter("recording"),
            text_for=lambda state: "Stop recording" if state.recording else "Record",
            icon_for=lambda state: "stop" if state.recording else "record",
            toolbar="session",
        ),
        ActionSpec(
            "record_for_viewers",
            "Record for viewers",
            "",
            "Recordings also contain what Foxglove, Lichtblick and Rerun show, which triples their size",
            checked=attrgetter("recorded_for_viewers"),
        ),
        LINE,
        ActionSpec("mark", "Mark this moment", "Ctrl+B", "Mark the moment that is recorded or shown", can_mark),
        ActionSpec("name_mark", "Name mark…", "Ctrl+Shift+B", "Mark this moment with a name", can_mark),
        ActionSpec("delete_mark", "Delete mark", "", "Delete the mark at the moment that is shown", has_marks),
        ActionSpec("previous_mark", "Previous mark", "Alt+Left", "Go to the previous mark", has_marks),
        ActionSpec("next_mark", "Next mark", "Alt+Right", "Go to the next mark", has_marks),
        LINE,
        ActionSpec("range_start", "Begin range", "Ctrl+[", "Begin the range at the moment that is shown", replaying),
        ActionSpec("range_end", "End range", "Ctrl+]", "End the range at the moment that is shown", replaying),
        ActionSpec("clear_range", "Clear range", "", "Remove the range", has_range),
        ActionSpec(
            "loop", "Loop range", "Ctrl+Alt+L", "Play the range repeatedly", has_range, checked=attrgetter("looping")
        ),
        ActionSpec(
            "trim_range",
            "Save range as recording…",
            "",
            "Write the range to a new recording; this one is not changed",
            has_range,
        ),
        ActionSpec(
            "whole_recording",
            "Whole recording",
            "F6",
            "Show the curves of the whole recording under the timeline, or of the last seconds",
            replaying,
            checkable=True,
        ),
        LINE,
        ActionSpec(
            "label_episode",
            "Range as episode…",
            "Ctrl+Shift+E",
            "Store the range as an episode with a label, an instruction and an outcome; exports use them",
            lambda state: state.notable and state.has_range,
        ),
        ActionSpec(
            "split_episodes",
            "Split at marks",
            "",
            "Make the parts between the marks episodes",
            lambda state: state.notable and state.has_marks,
        ),
        ActionSpec(
            "delete_episode",
            "Delete episode",
            "",
            "Delete the episode at the moment that is shown; the recording keeps its data",
            attrgetter("has_episodes"),
        ),
        ActionSpec(
            "save_episodes",
            "Save episodes as files…",
            "",
            "Write each episode to a recording of its own",
            attrgetter("has_episodes"),
        ),
        LINE,
        ActionSpec(
            "repeat_touches",
            "Repeat these touches live",
            "",
            "Restart the running scene, with its skin, map and controller, and repeat the touches of this recording",
            attrgetter("can_repeat"),
        ),
        Menu(
            "Second recording",
            (
                ActionSpec(
                    "overlay_recording",
                    "Overlay recording…",
                    "",
                    "Draw another recording of the same skin dashed over this one, its contacts as outlines",
                    replaying,
                ),
                ActionSpec(
                    "overlay_align", "Align first touches", "", "Shift it so that both first touches coincide", overlaid
                ),
                ActionSpec("overlay_earlier", "Earlier", "Alt+Shift+Left", "Start it 0.05 s earlier", overlaid),
                ActionSpec("overlay_later", "Later", "Alt+Shift+Right", "Start it 0.05 s later", overlaid),
                ActionSpec("overlay_offset", "Offset…", "", "Set how much later it starts", overlaid),
                ActionSpec("overlay_remove", "Remove overlay", "", "Show the first recording alone", overlaid),
            ),
        ),
        LINE,
        ActionSpec(
            "delete_recording", "Delete recording…", "", "Move the recording that is shown to the trash", replaying
        ),
    ),
)

_TOUCH = (
    LINE,
    ActionSpec(
        "save_script",
        "Save pokes as a script…",
        "",
        "Save the pokes since the last reset as a stimulus script",
        running,
    ),
    ActionSpec("play_script", "Play a script…", "", "Restart the scene and play a stimulus script", simulating),
    ActionSpec(
        "script_once",
        "Play the script once",
        "",
        "Restart the scene and play its stimulus script once; Reset plays it again",
        scripted,
        checked=partial(_is, "script_repeats", False),
        group="script",
    ),
    ActionSpec(
        "script_repeated",
        "Repeat the script",
        "",
        "Restart the scene and play its stimulus script again and again",
        scripted,
        checked=attrgetter("script_repeats"),
        group="script",
    ),
    LINE,
    ActionSpec(
        "weigh",
        "Known-load check (0.1 kg)",
        "",
        "Simulate 0.1 kg resting on the skin, in a separate process: the measured force must be 0.981 N",
        running,
    ),
)

_CONTROL = (
    LINE,
    Menu("Path shape", _PATH_ACTIONS),
    ActionSpec("more_force", "More force", "Alt+Up", "Increase the force goal by 0.5 N", can_control),
    ActionSpec("less_force", "Less force", "Alt+Down", "Decrease the force goal by 0.5 N", can_control),
    LINE,
    ActionSpec(
        "clear_path",
        "Clear path and target",
        "",
        "Remove the drawn path and target",
        lambda state: state.can_control and state.has_path,
    ),
    ActionSpec(
        "start_again",
        "Restart task",
        "Ctrl+Backspace",
        "Restart the task from its beginning",
        lambda state: state.mode.takes_input and state.can_restart_task,
    ),
    LINE,
    Menu(
        "Posture",
        (
            ActionSpec("scene_posture", "Scene posture", "", "Return to the home posture of the scene", can_pose),
            ActionSpec(
                "undo_posture",
                "Previous posture",
                "",
                "Return to the previous target posture",
                attrgetter("can_undo_posture"),
            ),
            ActionSpec("copy_posture", "Copy posture", "", "Copy the posture as text, one joint per line", can_pose),
            ActionSpec("paste_posture", "Paste posture", "", "Move to the copied posture", can_pose),
        ),
    ),
    LINE,
    ActionSpec("reset_gains", "Reset gains", "", "Reset all gains of the controller to the scene's values", running),
    ActionSpec(
        "compare_controllers",
        "Compare controllers…",
        "Ctrl+Shift+L",
        "Run several controllers on the same stimulus and compare their metrics",
        has_scene,
    ),
)

_SELECTION = (
    ActionSpec("smaller_brush", "Smaller brush", "[", "Make the selection brush smaller"),
    ActionSpec("larger_brush", "Larger brush", "]", "Make the selection brush larger"),
    LINE,
    ActionSpec("select_all", "Select all", "A", "Select every taxel"),
    ActionSpec("select_none", "Select none", "Alt+A", "Select no taxel, also by Escape"),
    ActionSpec("select_inverse", "Invert selection", "Ctrl+I", "Select the taxels that are not selected"),
    LINE,
    ActionSpec(
        "find_taxel",
        "Find taxel…",
        "Ctrl+F",
        "Select and show a taxel by its hardware id, its number, or its module and channel",
        has_scene,
    ),
)

_CAMERAS = (
    ActionSpec("frame", "Frame all", "Home", "Show the whole robot and the whole map", yields=True),
    MenuList("bodies", "Frame link"),
    ActionSpec(
        "show_bodies",
        "Show hidden links",
        "",
        "Show every link and object in the robot view again; a right click hides one",
        attrgetter("bodies_hidden"),
    ),
    ActionSpec(
        "second_view",
        "Second view",
        "",
        "Show the robot from another side too, in a panel that can be moved; it costs nothing while off",
        checkable=True,
    ),
    ActionSpec(
        "contact_inset",
        "Enlarge the contact",
        "",
        "Follow the strongest contact in a small view in the corner of the robot view; it costs nothing while off",
        checkable=True,
    ),
    ActionSpec("morph", "Body or map", "M", "Flatten the skin in the robot view, or put it back on the body"),
    ActionSpec("compare", "Other layout", "Ctrl+D", "Show the compared layout, or this map again"),
)

_WINDOW = (
    ActionSpec(
        "theme",
        "Light theme",
        "Ctrl+Shift+T",
        "Switch between light and dark theme",
        checked=attrgetter("light"),
    ),
    ActionSpec("panels", "Panels", "F2", "Show or hide the panels", checkable=True),
    ActionSpec("timing", "Timing", "F3", "Show the computing time of each stage"),
    ActionSpec("effects", "Effects", "F5", "Show the simulated effects, their reasons and cost"),
    ActionSpec(
        "plots", "Timeline and plots", "F4", "Show or hide the timeline and plots below the views", checkable=True
    ),
    Menu(
        "Plots",
        (
            ActionSpec(
                "choose_plots",
                "Choose plots…",
                "Shift+F4",
                "Show plots of any taxel, contact, link, joint, force, limit or event, and hide others",
            ),
            ActionSpec(
                "automatic_plots",
                "Follow the controller",
                "",
                "Show the standard plots that suit the controller",
            ),
            ActionSpec("export_plots", "Save plots as CSV…", "", "Write the samples that the plots show"),
        ),
    ),
    MenuList("layouts", "Layouts"),
    ActionSpec("save_layout", "Save layout…", "", "Save the arrangement of panels and windows under a name"),
    ActionSpec("delete_layout", "Delete layout…", "", "Delete a saved layout"),
    ActionSpec("reset_layout", "Reset layout", "", "Show both views equally wide, all panels in their column"),
    ActionSpec("full_screen", "Full screen", "F11", "Show the window on the whole screen", checkable=True),
)

_HELP = Menu(
    "Help",
    (
        ActionSpec("tour", "Take the tour", "", "Five steps to try in the window; Escape ends the tour", running),
        ActionSpec("guide", "Guide", "Shift+F1", "Open the user guide"),
        MenuList("findings", "Findings"),
        ActionSpec("keys", "Keys", "F1 ?", "List, search and change mouse gestures and keys; the list can stay open"),
        ActionSpec(
            "palette",
            "Commands…",
            "Ctrl+Shift+P",
            "Find any action, setting, scene, robot or recent file by a few letters",
        ),
        ActionSpec("about", "About Tactile Maps", "", "Show the versions of the program and its libraries"),
    ),
)


def _control_menu(tools: tuple[ToolSpec, ...]) -> Menu:
    controllers = (
        ActionSpec(
            f"controller_{name}",
            entry.title,
            f"Alt+{number}" if number < 10 else "",
            entry.tip,
            running,
            checked=partial(_is, "controller", name),
            group="controller",
        )
        for number, (name, entry) in enumerate(CONTROLLERS.items(), start=1)
    )
    tasks = (
        ActionSpec(
            f"task_{task}",
            text,
            "",
            f"{text}, with the controllers that have a task",
            has_tasks,
            checked=partial(_is, "task", task),
            group="task",
        )
        for task, text in SETTING_CHOICES["task"][1].items()
    )
    menus = (Menu("Controller", tuple(controllers)), Menu("Task", tuple(tasks)))
    return Menu("Control", (*menus, *_tools(ToolRole.CONTROL, tools), *_CONTROL))


def menu_bar(tools: tuple[ToolSpec, ...] = TOOLS, layers: tuple[LayerSpec, ...] = LAYERS) -> tuple[Menu, ...]:
    """Return the menus with the actions of these tools and layers."""
    overlay = Menu("Overlay", (*_BASE_LAYER_ACTIONS, LINE, *map(layer_action, layers)))
    return (
        _FILE,
        Menu("Edit", (*_UNDO, LINE, *_tools(ToolRole.EDIT, tools), LINE, *_MAP_EDITS, LINE, _PREFERENCES)),
        _SESSION,
        _RECORDING,
        Menu("Touch", (*_tools(ToolRole.POKE, tools), *_TOUCH)),
        _control_menu(tools),
        Menu("Select", (*_tools(ToolRole.SELECT, tools), *_SELECTION)),
        Menu("View", (*_CAMERAS, overlay, *_WINDOW)),
        _HELP,
    )


REMEDIES = (
    ActionSpec("choose_links", "Choose…", "", "Choose the links that the skin covers, and their taxels"),
    ActionSpec("save_report", "Save report", "", "Save a recording that reproduces the failure"),
    ActionSpec(
        "open_path_scene",
        "Open Follow a path",
        "",
        "Open the scene in which the arm moves the contact with a fixed knob",
    ),
    ActionSpec("replay_saved", "Replay", "", "Replay the recording that was saved"),
    ActionSpec("show_saved", "Show in folder", "", "Show the folder of the recording that was saved"),
    ActionSpec("restore_recording", "Undo", "", "Move the deleted recording and its notes back from the trash"),
    ActionSpec("simulate_fingers", "Simulate fingers", "", "Simulate fingers, so that the skin can be pressed"),
    ActionSpec("go_there", "Move there", "", "Resume, and let the controller move the robot to the posture", can_pose),
    ActionSpec("use_anyway", "Use anyway", "", "Simulate in spite of the warning"),
    ActionSpec("tare_again", "Tare again", "", "Use the next 50 readings as those of the untouched skin", measured),
)
"""Actions that only messages offer."""

_NAVIGATION = {
    NavigationStyle.STANDARD: (
        ("Right-drag, or Ctrl-drag, anywhere", "turn the view over the skin too; on the map, move it"),
        ("Middle-drag, Shift-drag or Space-drag, anywhere", "move the view"),
    ),
    NavigationStyle.MUJOCO: (
        ("Ctrl-drag, anywhere", "turn the view over the skin too; on the map, move it"),
        ("Right-drag, Shift-drag or Space-drag, anywhere", "move the view"),
        ("Middle-drag, anywhere", "zoom"),
    ),
    NavigationStyle.BLENDER: (
        ("Middle-drag, Right-drag or Ctrl-drag, anywhere", "turn the view over the skin too; on the map, move it"),
        ("Shift-middle-drag, Shift-drag or Space-drag, anywhere", "move the view"),
        ("Ctrl-middle-drag, anywhere", "zoom"),
    ),
}


def mouse_gestures(style: NavigationStyle) -> tuple[tuple[str, str], ...]:
    """Return all mouse gestures and their effects."""
    return (_GESTURES[0], *_NAVIGATION[style], *_GESTURES[1:])


_GESTURES = (
    ("Drag next to the robot", "turn the view; with Shift, move it"),
    ("Wheel", "zoom; on a control only after a click on it"),
    ("Click a side of the cube", "look from that side"),
    ("Double-click next to robot or map", "frame all"),
    ("Press the skin or the map", "poke; the force grows while the button is held"),
    ("Drag along it", "stroke"),
    ("Shift-click the skin or the map", "leave a finger there; the Contacts panel sets its force and removes it"),
    ("Right-click", "menu for that place: poke, target, path, plot, frame, hide, skin, copy"),
    ("Escape", "release the poke, cancel a selection being drawn, or select none"),
    ("Click, or drag around, with Select", "select taxels, on the map or on the body"),
    ("Drag a patch with Arrange", "move it; its corners scale, its handle rotates; Ctrl turns snapping off"),
    ("Shift while dragging it", "move along one axis, scale about the middle, rotate by 15°"),
    ("Arrow keys with Arrange", "move the patches by 1 mm, with Shift by 10 mm"),
    ("Drag a pin with Pins", "the map follows; click the skin to pin it"),
    ("Drag along the skin with Seams", "draw a seam; Alt erases one"),
    ("Enter, Escape", "accept or decline a proposed seam"),
    ("Click or drag with Path", "draw; Enter or a double click ends, Backspace removes the last corner"),
    ("Drag a path's corner, side or line", "move it, add a corner, move all of it; Delete removes a corner"),
    ("Click or drag with Target", "hold the contact there, move it along"),
    ("Drag a link with Drag links", "the joints follow within their limits; while paused the robot is placed there"),
    ("Wheel or drag on the force, Page Up and Down", "0.5 N more or less, with Path and Target"),
    ("Shift-drag along the timeline", "choose a range of the recording to loop, save or label"),
    ("Wheel, drag, double-click on a recording's curves", "zoom, choose a range, show all; a click goes to that time"),
    ("Right-click on the timeline", "menu for that moment: mark it, begin or end the range there"),
    ("→", "one control tick while paused, or one tick of a replay"),
)
