"""Studies of single stages, one module each, named like the command.

``map_cost``      distortion and time of flattening, by method, seams and mesh
``image_cost``    error and time of a tactile image, by interpolation, taxels and pixels
``touch_cost``    error and time of a reading, by contact model
``force_estimators``  error of force estimators, by noise and depth of taxels
``step_cost``     stable contacts by integrator and time step; its table is ``assets/stability.json``
``contact``       contacts compared with mechanics, by skin, shape, contact model, integrator, time step and rate
``effect_cost``   time of each effect, as a multiple of a step without effects
``needs``         whether a scene simulates what it needs and nothing else
``controller_accuracy``  accuracy of controllers on robots, with skin or force-torque sensor
"""
