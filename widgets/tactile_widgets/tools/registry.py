"""Registry of the tools, one entry each. ``Tools`` creates them and manages the active tool and its undo."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

from PySide6.QtCore import QObject, Signal

from tactile_widgets.common.tool_kinds import POKE, SELECT_BOX, SELECT_BRUSH, SELECT_LASSO, ToolKind, ToolRole
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.document.posture_editor import PostureEditor
from tactile_widgets.document.skin_steps import SkinSteps
from tactile_widgets.tools.control.control_settings_editor import ControlSettingsEditor
from tactile_widgets.tools.control.path_tool import PathTool
from tactile_widgets.tools.control.posture_tool import PostureTool
from tactile_widgets.tools.control.target_tool import TargetTool
from tactile_widgets.tools.map_editing.arrange_tool import ArrangeTool
from tactile_widgets.tools.map_editing.grid_tool import GridTool
from tactile_widgets.tools.map_editing.interest_tool import InterestTool
from tactile_widgets.tools.map_editing.pin_tool import PinTool
from tactile_widgets.tools.map_editing.seam_tool import SeamTool
from tactile_widgets.views.interaction.view_tool import ViewTool


@dataclass(frozen=True, eq=False)
class ToolContext:
    """Editors that a tool may use.

    Attributes:
        editor: Map editor.
        control: Editor of the controller's path, target and force.
        posture: Editor of the robot's posture.
        parent: Qt parent of the tools.
    """

    editor: MapEditor
    control: ControlSettingsEditor
    posture: PostureEditor
    parent: QObject


@dataclass(frozen=True)
class ToolSpec:
    """Description of a tool.

    Attributes:
        kind: Name and role, which determine the menu and the position in the toolbar.
        text: Menu text.
        key: Shortcut while one of the views has the focus.
        tip: Description in one sentence.
        make: Creates the handler of mouse events; None for a tool that the views implement.
    """

    kind: ToolKind
    text: str
    key: str
    tip: str
    make: Callable[[ToolContext], ViewTool] | None = None


ARRANGE = ToolKind("arrange", ToolRole.EDIT)
PINS = ToolKind("pins", ToolRole.EDIT)
SEAMS = ToolKind("seams", ToolRole.EDIT)
INTEREST = ToolKind("interest", ToolRole.EDIT)
GRID = ToolKind("grid", ToolRole.EDIT)
PATH = ToolKind("draw_path", ToolRole.CONTROL)
TARGET = ToolKind("set_target", ToolRole.CONTROL)
POSTURE = ToolKind("posture", ToolRole.CONTROL)

TOOLS = (
    ToolSpec(POKE, "Poke", "T", "Press the skin to poke it"),
    ToolSpec(
        SELECT_BOX,
        "Select by box",
        "B",
        "Click taxels, or drag a box around them; Ctrl or Shift adds, Alt removes",
    ),
    ToolSpec(
        SELECT_LASSO,
        "Select by lasso",
        "L",
        "Click taxels, or draw a line around them; Ctrl or Shift adds, Alt removes",
    ),
    ToolSpec(
        SELECT_BRUSH,
        "Select by brush",
        "C",
        "Paint over taxels; [ and ] change the brush, Ctrl or Shift adds, Alt removes",
    ),
    ToolSpec(
        ARRANGE,
        "Arrange patches",
        "V",
        "Click patches to select them, drag to move, rotate or scale them",
        lambda context: ArrangeTool(context.editor, context.parent),
    ),
    ToolSpec(
        PINS,
        "Pins",
        "N",
        "Click the skin to pin it to the map, drag pins to deform the map",
        lambda context: PinTool(context.editor, context.parent),
    ),
    ToolSpec(
        SEAMS,
        "Seams",
        "K",
        "Draw seams on body or map where the skin is cut; Alt erases",
        lambda context: SeamTool(context.editor, context.parent),
    ),
    ToolSpec(
        INTEREST,
        "Areas of interest",
        "I",
        "Paint where no seam may go; Alt erases, [ and ] change the brush",
        lambda context: InterestTool(context.editor, context.parent),
    ),
    ToolSpec(
        GRID,
        "Taxel grid",
        "E",
        "Click two opposite corners of an e-skin on the body, and place rows and columns of taxels between them",
        lambda context: GridTool(context.editor, context.parent),
    ),
    ToolSpec(
        PATH,
        "Path",
        "D",
        "Click the corners of a path on map or body, or draw it in one stroke; Enter ends it, drag its corners",
        lambda context: PathTool(context.control, context.parent),
    ),
    ToolSpec(
        TARGET,
        "Target",
        "G",
        "Click on map or body where to hold the contact; drag to move the target",
        lambda context: TargetTool(context.control, context.parent),
    ),
    ToolSpec(
        POSTURE,
        "Drag links",
        "J",
        "Drag a link of the robot: the joints follow; while paused the robot is placed there, else it moves there",
        lambda context: PostureTool(context.posture, context.parent),
    ),
)
"""All tools. Actions, keys, buttons and both views are created from these entries."""


class Undoable(Protocol):
    """Object whose last step can be undone."""

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo."""

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone step to redo."""

    @property
    def undo_name(self) -> str:
        """Name of the step that ``undo`` reverts; empty if there is none."""

    @property
    def redo_name(self) -> str:
        """Name of the step that ``redo`` repeats; empty if there is none."""

    def undo(self) -> None:
        """Undo the last step."""

    def redo(self) -> None:
        """Redo the last undone step."""


class MapUndo:
    """Undo of map edits and of the changes of the skin between them."""

    def __init__(self, editor: MapEditor, skins: SkinSteps) -> None:
        self._editor = editor
        self._skins = skins

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo or an edit being computed."""
        history = self._editor.history
        editor = self._editor
        return history is not None and editor.enabled and (history.can_undo or editor.busy or self._skins.can_undo)

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone step to redo."""
        history = self._editor.history
        return history is not None and self._editor.enabled and (history.can_redo or self._skins.can_redo)

    @property
    def undo_name(self) -> str:
        """Name of the step that ``undo`` reverts."""
        history = self._editor.history
        if history is None or not history.position or self._skins.pending:
            return self._skins.undo_name
        return history.names[history.position]

    @property
    def redo_name(self) -> str:
        """Name of the step that ``redo`` repeats."""
        history = self._editor.history
        if history is not None and history.can_redo:
            return history.names[history.position + 1]
        return self._skins.redo_name if self._skins.can_redo else ""

    def undo(self) -> None:
        """Undo the last map edit, or the last change of the skin; one that is being made is cancelled first."""
        editor = self._editor
        history = self._editor.history
        if self._skins.pending and not editor.gesture:
            self._skins.undo()
        elif history is None or history.can_undo or editor.busy or editor.proposal is not None:
            editor.undo()
        else:
            self._skins.undo()

    def redo(self) -> None:
        """Redo the last undone map edit, or change of the skin."""
        history = self._editor.history
        if history is None or history.can_redo:
            self._editor.redo()
        else:
            self._skins.redo()


class ControlUndo:
    """Undo of path, target and force, and of the corners of a path while it is being drawn."""

    def __init__(self, control: ControlSettingsEditor, path: PathTool) -> None:
        self._control = control
        self._path = path

    @property
    def can_undo(self) -> bool:
        """Whether there is a corner, a gesture or a step to undo."""
        control = self._control
        return control.enabled and (self._path.drawing or bool(control.gesture or control.undo_name))

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone step to redo and no path is being drawn."""
        return self._control.enabled and bool(self._control.redo_name) and not self._path.drawing

    @property
    def undo_name(self) -> str:
        """Name of the step that ``undo`` reverts."""
        return self._control.undo_name

    @property
    def redo_name(self) -> str:
        """Name of the step that ``redo`` repeats."""
        return self._control.redo_name

    def undo(self) -> None:
        """Remove the last corner of the path being drawn, or undo the last step."""
        if self._path.drawing:
            self._path.remove_last()
        else:
            self._control.undo()

    def redo(self) -> None:
        """Redo the last undone step."""
        self._control.redo()


T = TypeVar("T", bound=ViewTool)


class Tools(QObject):
    """All tools and the active one.

    Args:
        editor: Map editor.
        parent: Qt parent.
        specs: Available tools.

    Attributes:
        control: Editor of the controller settings.
        posture: Editor of the robot's posture.
        skin_steps: Changes of the skin.
        active: Active tool.
    """

    changed = Signal(ToolKind)
    """A tool was selected, possibly the same again."""
    undo_changed = Signal()
    """The steps that can be undone or redone may have changed."""

    def __init__(self, editor: MapEditor, parent: QObject | None = None, *, specs: Sequence[ToolSpec] = TOOLS) -> None:
        super().__init__(parent)
        self.specs = tuple(specs)
        self.active = POKE
        self._lent_undo: Undoable | None = None
        self.control = ControlSettingsEditor(self)
        self.posture = PostureEditor(self)
        context = ToolContext(editor, self.control, self.posture, self)
        self._made = {spec.kind: spec.make(context) for spec in specs if spec.make is not None}
        path = self.get(PathTool)
        self.skin_steps = SkinSteps(editor, self)
        self._map_undo = MapUndo(editor, self.skin_steps)
        self._control_undo = ControlUndo(self.control, path)
        for signal in (
            self.control.changed,
            path.drawn,
            editor.history_changed,
            editor.gesture_changed,  # undo cancels a drag before it has become a step
            editor.enabled_changed,
            self.skin_steps.changed,
            self.posture.changed,
        ):
            signal.connect(self.undo_changed)

    def take(self, kind: ToolKind) -> None:
        """Activate a tool."""
        self.active = kind
        self.changed.emit(kind)
        self.undo_changed.emit()

    @property
    def view_tool(self) -> ViewTool | None:
        """Handler of mouse events of the active tool; None if the views implement it."""
        return self._made.get(self.active)

    @property
    def undo_stack(self) -> Undoable:
        """Undo stack of the active tool (controller settings, postures, or map and grids), or the lent one."""
        if self._lent_undo is not None:
            return self._lent_undo
        if self.active == POSTURE:
            return self.posture
        return self._control_undo if self.active.controls else self._map_undo

    def lend_undo(self, stack: Undoable | None) -> None:
        """Let undo and redo use another stack; None restores the stack of the tools."""
        self._lent_undo = stack
        self.undo_changed.emit()

    def get(self, kind: type[T]) -> T:
        """Return the tool of a class."""
        return next(tool for tool in self._made.values() if isinstance(tool, kind))
