"""The stages whose accuracy and time are measured, each one file of the same shape.

``registry`` lists them. ``cut`` (how many seams), ``flatten`` (which method); what these two have in common, charts
made by the clock and judged, is in ``timed_flattening``. ``image`` (which interpolation, how many pixels), ``touch``
(which contact model), ``simulation`` (which integrator, how long a time step), ``control`` (which controller, how
fast). What a stage consists of is in ``tactile_maps.studies.study.work_precision``.

``flatten_timed``, ``frame_trial``, ``touch_trial`` and ``step_trial`` are what measures, for the user's own skin here
and for subjects whose truth is known in ``tactile_maps.studies.sweeps``.
"""
