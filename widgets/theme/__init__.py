"""Theme of the application: ``application_theme`` dresses it, ``dialog_icons`` are those of Qt's own file dialog."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
