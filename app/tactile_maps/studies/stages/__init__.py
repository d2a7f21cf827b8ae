"""Stages whose accuracy and time are measured, one module each; ``registry`` lists them.

``cut``         number of seams
``flatten``     method; ``timed_flattening`` is shared with ``cut``
``image``       interpolation and number of pixels
``touch``       contact model
``simulation``  integrator and time step
``control``     controller and speed

``tactile_maps.studies.study.work_precision`` defines a stage. The measurements (``flatten_timed``, ``frame_trial``,
``touch_trial`` and ``step_trial``) are used here with the user's skin and in ``tactile_maps.studies.sweeps`` with
testbeds.
"""
