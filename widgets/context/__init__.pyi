from .app_context import AppContext
from .dialogs import Dialogs
from .linked_views import LinkedViews
from .notifier import Notifier

__all__ = [
    "AppContext",
    "Dialogs",
    "LinkedViews",
    "Notifier",
]
