from .bijectivity import crossings, flipped
from .chart import Chart, Pin
from .cut import SeamPlan, cut_to_disk, shortest_edge_path
from .flatten import seam_curve
from .methods import METHODS, Method, find_method
from .pinned_patch import PinnedPatch

__all__ = [
    "METHODS",
    "Chart",
    "Method",
    "Pin",
    "PinnedPatch",
    "SeamPlan",
    "crossings",
    "cut_to_disk",
    "find_method",
    "flipped",
    "seam_curve",
    "shortest_edge_path",
]
