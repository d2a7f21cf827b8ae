"""The tools a person takes; ``registry`` lists them.

``map_editing`` has those that edit the map through the editor, ``control`` those that set path, target and force
through the settings editor.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
