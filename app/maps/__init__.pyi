from .build import build_map
from .evaluation.comparison import TaxelLayout, compare_maps
from .evaluation.quality import MapQuality, measure
from .evaluation.topography import BodyDistances, measure_topography
from .interpolation import INTERPOLATIONS
from .jacobian import MapJacobian
from .layout import MapLayout, Placement, pack_charts
from .paths import MapPath, draw_path
from .seam_transitions import SeamTransitions
from .tactile_image import TactileImage
from .tactile_map import BodyPoint, TactileMap, back_project

__all__ = [
    "INTERPOLATIONS",
    "BodyDistances",
    "BodyPoint",
    "MapJacobian",
    "MapLayout",
    "MapPath",
    "MapQuality",
    "Placement",
    "SeamTransitions",
    "TactileImage",
    "TactileMap",
    "TaxelLayout",
    "back_project",
    "build_map",
    "compare_maps",
    "draw_path",
    "measure",
    "measure_topography",
    "pack_charts",
]
