from .effects import EFFECTS, Effects
from .motion import Waypoint
from .objects import ObjectSpec, SceneObject
from .scene import Scene
from .scene_file import load_scene, scene_for, scene_from_toml, scene_names, scene_to_toml
from .tasks import OUTPUTS, TASKS

__all__ = [
    "EFFECTS",
    "OUTPUTS",
    "TASKS",
    "Effects",
    "ObjectSpec",
    "Scene",
    "SceneObject",
    "Waypoint",
    "load_scene",
    "scene_for",
    "scene_from_toml",
    "scene_names",
    "scene_to_toml",
]
