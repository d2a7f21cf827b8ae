from .known_load_check import weigh
from .model.model_assembly import assemble
from .simulation import Simulation

__all__ = [
    "Simulation",
    "assemble",
    "weigh",
]
