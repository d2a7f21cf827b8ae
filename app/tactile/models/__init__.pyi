from .contact_model import CONTACT_MODELS, ContactModel

__all__ = [
    "CONTACT_MODELS",
    "ContactModel",
]
