"""Estimators of the force of a contact, with one protocol.

``estimate``             the protocol, its input and output, and the default estimator: pressure times area
``deconvolution``        removes the blur of the cover, by non-negative least squares or Tikhonov regularization, and
                         refuses where the readings do not determine the pressures
``force_torque_sensor``  what a force-torque sensor in the link would measure without a skin
``wrench_consistency``   tests whether one contact explains the wrench of such a sensor
``estimation``           estimators by name, and regions with the estimated force

No estimator returns net shear: below a cover it adds up to zero in the normal stress of each taxel (the mean of
Cerruti's field is zero), so taxels that measure normal stress cannot observe it.
"""
