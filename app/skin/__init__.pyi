from .calibration_error import with_calibration_error
from .cover import CoverSpec, choose_links, cover_robot
from .fit import fit_taxels_to_link
from .mesh_skin import skin_of_mesh
from .open import SkinOptions, open_skin
from .reconstruction.reconstruct import ReconstructedSkin, reconstruct_skin, skin_from_taxels
from .skin import Patch, Quadrature, Skin, TaxelIdentity, TaxelName, Taxels
from .skin_file import load_skin, save_skin
from .taxel_placement.placement import (
    BoundaryZone,
    BoxZone,
    PaintedZone,
    PlacementSpec,
    SphereZone,
    place_taxels,
    refine_for_spec,
)

__all__ = [
    "BoundaryZone",
    "BoxZone",
    "CoverSpec",
    "PaintedZone",
    "Patch",
    "PlacementSpec",
    "Quadrature",
    "ReconstructedSkin",
    "Skin",
    "SkinOptions",
    "SphereZone",
    "TaxelIdentity",
    "TaxelName",
    "Taxels",
    "choose_links",
    "cover_robot",
    "fit_taxels_to_link",
    "load_skin",
    "open_skin",
    "place_taxels",
    "reconstruct_skin",
    "refine_for_spec",
    "save_skin",
    "skin_from_taxels",
    "skin_of_mesh",
    "with_calibration_error",
]
