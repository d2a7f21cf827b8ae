from .export import write_map
from .map_file import edit_from_bytes, edit_to_bytes, load_map, map_from_bytes, map_to_bytes, save_map
from .obj import read_map_obj, write_map_obj
from .png import write_distortion_png, write_image_png
from .svg import write_svg
from .unige import write_unige_map

__all__ = [
    "edit_from_bytes",
    "edit_to_bytes",
    "load_map",
    "map_from_bytes",
    "map_to_bytes",
    "read_map_obj",
    "save_map",
    "write_distortion_png",
    "write_image_png",
    "write_map",
    "write_map_obj",
    "write_svg",
    "write_unige_map",
]
