"""Ways from readings to a contact's force, behind one protocol.

``estimate`` holds the protocol, what goes in and what comes out. ``area_sum`` is the default: pressure times area,
hard to beat for a total. ``local_nnls`` and ``tikhonov`` undo the cover's blur (``spread``) to find how the force is
distributed, and refuse where readings do not tell (``rank``). ``lumped`` is what a force-torque sensor at the link
would know without a skin, from a ``wrench``. ``table`` lists them by name.

Net shear is in none of them: below a cover it adds up to zero in every taxel's normal stress (Cerruti's field has no
mean), so taxels that feel normal stress cannot observe it, and nothing here pretends to estimate it.
"""
