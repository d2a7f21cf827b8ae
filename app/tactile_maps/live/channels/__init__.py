"""Channels of readings: taxels, pressures and faults.

``matching``           taxel of each value
``calibration``        pressure of a value; ``weighing`` calibrates with a known weight
``tare``               baseline and noise of the untouched skin, without touches meanwhile
``force_calibration``  curves of taxels from a log of known loads, which ``calibration_log`` reads
``channel_health``     channels that never change while their neighbours do
``broken_channels``    channels whose silence is a fault
``falling_values``     values that fall where the skin seems to be touched
``shear_channels``     shear values of three-axis taxels
``channel_swaps``      pairs of channels that are probably exchanged
``last_heard``         time of the last value of each taxel and joint, and parts of the skin that repeat values
"""
