"""Effects of a sensor between true pressure and reading.

``sensor_effects``  the effects, each switched on separately
``sensor_chain``    the selected effects in order, with stages of plug-ins
"""
