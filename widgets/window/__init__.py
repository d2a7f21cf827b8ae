"""The application and its main window.

``application`` starts it, on a display or for a picture; ``main_window`` puts views, panels, menus and presenters
together and decides nothing; ``toolbar`` shows the state of the session.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
