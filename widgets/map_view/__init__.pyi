from .map_view import MapView

__all__ = ["MapView"]
