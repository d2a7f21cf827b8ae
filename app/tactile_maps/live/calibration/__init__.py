"""Calibration of real skins: from values to pressures, and to places on the body.

``calibration``         pressure of a value; ``weighing`` calibrates with a known weight
``calibration_log``     logs of known loads
``force_calibration``   curves of taxels from a log; ``force_curves`` fits and chooses them
``matrix_calibration``  3 x 3 matrices of three-axis taxels from a log of known forces
``touch_log``           logs of touches at known places
"""
