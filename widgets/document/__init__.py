"""What is edited and selected, independent of any view.

``stage_settings`` brings the document to the stages that ``app.studies`` measures, and their settings back.
``map_editor`` is the only caller that changes the map document; ``taxel_selection`` is which taxels and which contact
region are selected, and their colours; ``taxel_search`` finds taxels by id, number or module.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
