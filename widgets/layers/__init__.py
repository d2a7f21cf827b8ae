"""The layers of View > Overlay: ``registry`` is one line each, for the map, the body, the menu and the settings."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
