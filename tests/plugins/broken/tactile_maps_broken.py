"""What can be wrong with a plug-in."""

import numpy as np

from app.flattening.methods import Method
from app.skin.formats.taxel_files import TaxelFormat
from app.tactile.models.contact_model import ContactModelEntry


def _fail(disk, lengths):
    yield disk.start
    raise ZeroDivisionError("by a stranger")


TUTTE = Method("tutte", "the name of a built-in one", _fail)
WRONG_CALL = Method("wrong-call", "takes one argument", lambda disk: iter(()))
WRONG_KIND = {"name": "wrong-kind"}
FAILING = Method("failing", "fails at work", _fail)
SHORT = Method("short", "too few vertices", lambda disk, lengths: iter([np.zeros((2, 2))]))
EMPTY_HANDED = ContactModelEntry("empty-handed", "Empty", "Builds no model.", lambda skin, layer, sensor: object())
TAKEN = TaxelFormat("taken", "Tables", (".csv",), lambda path: ())
