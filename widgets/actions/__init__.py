"""Everything a person can ask of the window by menu, key or button.

``registry`` is the table of actions and makes them, with their shortcuts and the list of keys; ``menus`` arranges them;
``icons`` draws the few that the toolbar shows.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
