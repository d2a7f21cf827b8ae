"""Session on measured readings.

``measured_session``  frames with contacts, events and forces from readings of a real skin
``skin_readings``     newest values of the taxels: units, tare, calibration, displayed pressures
``known_weights``     calibration with known weights, with undo
``measured_joints``   posture by the joint positions in readings
``session_clock``     session time by the sender's clock
``implausible``       count of impossible values
``facts``             facts about the readings for display
``connection``        a source that is opened again when it fails
"""
