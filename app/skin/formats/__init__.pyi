from .icub_layout import IcubLayout, LayoutModule, apply_layout, read_icub_layout, write_icub_layout
from .icub_module_orientation import propose_orientations
from .icub_positions import import_icub_skin, read_icub_positions, write_icub_positions
from .taxel_files import read_taxel_sets, read_taxels, write_taxels
from .taxel_set import TaxelSet
from .unige_json import UnigeFile, UnigeMap, read_unige, write_unige

__all__ = [
    "IcubLayout",
    "LayoutModule",
    "TaxelSet",
    "UnigeFile",
    "UnigeMap",
    "apply_layout",
    "import_icub_skin",
    "propose_orientations",
    "read_icub_layout",
    "read_icub_positions",
    "read_taxel_sets",
    "read_taxels",
    "read_unige",
    "write_icub_layout",
    "write_icub_positions",
    "write_taxels",
    "write_unige",
]
