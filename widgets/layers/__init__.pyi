from .registry import LAYERS, LayerSpec

__all__ = [
    "LAYERS",
    "LayerSpec",
]
