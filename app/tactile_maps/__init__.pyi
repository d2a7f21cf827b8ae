from .contacts.detection.regions import ContactRegion
from .contacts.pipeline import read_contacts
from .control.motion.command import ControlSettings
from .core.errors import TactileMapsError
from .maps.build import build_map
from .maps.evaluation.comparison import compare_maps
from .maps.evaluation.quality import measure
from .maps.formats.map_file import load_map, save_map
from .maps.model.tactile_image import TactileImage
from .maps.model.tactile_map import TactileMap, back_project
from .plot import draw_contacts, draw_forces, draw_map
from .recording.player import open_recording
from .recording.recorder import record
from .robots.kinematics import Configuration
from .robots.library import list_robots, load_robot
from .robots.model.robot import Robot
from .scene.scene import Scene
from .scene.scene_file import load_scene
from .session.frame import Frame
from .session.prepare import prepare
from .session.session import Session
from .skin.fitting.cover import CoverSpec, cover_robot
from .skin.model.skin import Skin
from .skin.open import SkinOptions, open_skin
from .tactile.press import press_skin

__all__ = [
    "Configuration",
    "ContactRegion",
    "ControlSettings",
    "CoverSpec",
    "Frame",
    "Robot",
    "Scene",
    "Session",
    "Skin",
    "SkinOptions",
    "TactileImage",
    "TactileMap",
    "TactileMapsError",
    "back_project",
    "build_map",
    "compare_maps",
    "cover_robot",
    "draw_contacts",
    "draw_forces",
    "draw_map",
    "list_robots",
    "load_map",
    "load_robot",
    "load_scene",
    "measure",
    "open_recording",
    "open_skin",
    "prepare",
    "press_skin",
    "read_contacts",
    "record",
    "save_map",
]
