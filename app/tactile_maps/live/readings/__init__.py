"""Readings and their transport.

``readings``     ``Reading`` (time, values, ids or channels, joint positions) and ``Source``, the interface of sources
``wire_format``  packets as JSON or compact binary
``arrival``      order of readings; counts of malformed, late, repeated and lost ones
``data_age``     age of readings from two clocks with an unknown offset
``joint_range``  plausible positions of a joint
``tables``       CSV and TOML tables in files that people write
"""
