"""The studies, one a file, called as the command line calls them.

``map_cost``     which method flattens a body with how little distortion in how many seconds
``image_cost``   which interpolation gives how small an error at how many milliseconds a frame
``touch_cost``   which contact model gives how small an error at how many milliseconds a reading
``force_estimators``  which estimator of force is how far off, by noise and depth of the taxels
``step_cost``    which integrator holds which contact at which time step (``assets/stability.json`` is its table)
``contact``      which contacts obey mechanics, by skin, shape, contact model, integrator, time step and rate
``effect_cost``  what each effect costs, as a multiple of a bare step
``needs``        whether all is simulated that a scene calls for, and nothing else
``controller_accuracy``  which controller follows how well on which robot, by its skin or by a force-torque sensor
"""
