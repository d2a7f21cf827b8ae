"""Ways from readings to a contact's force, behind one protocol.

``estimate`` holds the protocol, what goes in and what comes out, and the default: pressure times area, hard to beat for
a total. ``deconvolution`` undoes the cover's blur, by non-negative least squares or Tikhonov's regularization, and
refuses where readings do not tell. ``force_torque_sensor`` is what a sensor in the link would know without a skin, and
``wrench_consistency`` whether the skin's contacts let it be one contact.
``estimation`` makes them by name, and gives regions what the chosen one finds.

Net shear is in none of them: below a cover it adds up to zero in every taxel's normal stress (Cerruti's field has no
mean), so taxels that feel normal stress cannot observe it, and nothing here pretends to estimate it.
"""
