"""What is edited and selected, independent of any view.

``map_editor`` is the only caller that changes the map document; ``taxel_selection`` is which taxels and which contact
region are selected, and their colours.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
