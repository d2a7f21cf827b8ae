"""Contacts read from the tactile map: touched areas, their forces and their places on map and body.

``pipeline``          the whole path from pressures of one tick to regions, self-touch and events
``detection``         finds contact regions, places them on map and body, and tracks them
``force_estimation``  estimators of a region's force
``self_touch``        pairs of regions where the robot touches itself
``events``            begin, end and motion of contacts as symbols
"""
