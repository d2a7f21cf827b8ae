from .contact_notes import ContactNote, ContactNoteKind, contact_note_text
from .elastic_layer import ElasticLayer
from .half_space_stress import GridBlur, disc_stress, subsurface_field
from .loads import Box, Cylinder, Load, MeshShape, Plane, Shape, Sphere, sphere_load
from .poke import Finger, PokeMoved, PokePressed, PokeReleased, PokeState
from .press import press_skin
from .receptive_field import ReceptiveField, cell_field, disc_field, quadrature_points
from .sensor_chain import SensorChain
from .sensor_effects import SensorEffects

__all__ = [
    "Box",
    "ContactNote",
    "ContactNoteKind",
    "Cylinder",
    "ElasticLayer",
    "Finger",
    "GridBlur",
    "Load",
    "MeshShape",
    "Plane",
    "PokeMoved",
    "PokePressed",
    "PokeReleased",
    "PokeState",
    "ReceptiveField",
    "SensorChain",
    "SensorEffects",
    "Shape",
    "Sphere",
    "cell_field",
    "contact_note_text",
    "disc_field",
    "disc_stress",
    "press_skin",
    "quadrature_points",
    "sphere_load",
    "subsurface_field",
]
