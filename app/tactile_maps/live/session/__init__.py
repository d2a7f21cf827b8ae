"""Session on measured readings.

``measured_session``  frames with contacts, events and forces from readings of a real skin
``connection``        a source that is opened again when it fails
"""
