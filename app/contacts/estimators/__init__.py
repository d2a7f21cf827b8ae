"""Ways from readings to a contact's force, behind one protocol.

``estimate`` holds the protocol, what goes in and what comes out. ``area_sum`` is the default: pressure times area, hard
to beat for a total. ``local_nnls`` and ``tikhonov`` are solvers that undo the cover's ``blur`` (from ``spread``);
``unblurred`` asks them how the force is distributed, and refuses where readings do not tell (``rank``). ``lumped`` is
what a force-torque sensor at the link would know without a skin, from a ``wrench``. ``table`` makes them by their
``names``.

Net shear is in none of them: below a cover it adds up to zero in every taxel's normal stress (Cerruti's field has no
mean), so taxels that feel normal stress cannot observe it, and nothing here pretends to estimate it.
"""
