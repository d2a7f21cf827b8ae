from .closest_point import ClosestPoint
from .connectivity import Connectivity
from .geodesics import Geodesics
from .mesh import Mesh, SurfacePoint
from .pose import Pose
from .raycast import RayCaster
from .remesh.repair import clean_mesh, repair_mesh
from .remesh.wrap import wrap_mesh

__all__ = [
    "ClosestPoint",
    "Connectivity",
    "Geodesics",
    "Mesh",
    "Pose",
    "RayCaster",
    "SurfacePoint",
    "clean_mesh",
    "repair_mesh",
    "wrap_mesh",
]
