"""Readings of real skins, from a file, a network, a serial port or a robot's middleware, as frames of a session.

- ``readings``: the interface: one ``Reading`` of time, values with their unit, ids or channels, and joint positions.
- ``wire_format``: packets, as JSON or compact binary; ``send`` writes them.
- ``sources``: where readings come from; ``open_source`` chooses one by its address.
- ``arrival``: puts them in order and counts what is malformed, late, repeated or lost.
- ``data_age``: how old readings were when they arrived, by two clocks that share no zero.
- ``connection``: a source that is opened again when it breaks, by hand or on a thread.
- ``channels``: which taxel each value is of, what pressure it means, and which channels to doubt.
- ``measured_session``: what a ``Session`` is for a simulation: frames with contacts, events and forces.
- ``motion``: what a controller wants of a real robot: shown, and sent where a person says so.
- ``frame_recording``: frames written to a recording on a thread of its own.
- ``simulated_skin``: what the skin should read in the measured posture, and the difference.
- ``prepare``: the robot, skin and map that readings are shown on.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
