"""Readings of real skins as frames of a session: from files, networks, serial ports or robot middleware.

``readings``         interface of all sources, packets, order of arrival and age of readings
``sources``          sources by address: files, UDP, ZeroMQ, serial port, ROS 2, YARP
``channels``         taxel of each value, tare, and channels that may be broken
``calibration``      pressure of each value, fitted to known weights and logs of loads
``session``          a session on measured readings, and its connection to a source
``checking``         guided check of a skin, part by part, and its report
``motion``           motion that a controller requests of the real robot, and its transmission
``prepare``          robot, skin and map for the readings
``frame_recording``  recording of frames on a separate thread
``simulated_skin``   simulated readings at the measured posture, and the difference
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
