from .live_image import ImageAtlas, ImageSettings
from .map_view import MapView

__all__ = [
    "ImageAtlas",
    "ImageSettings",
    "MapView",
]
