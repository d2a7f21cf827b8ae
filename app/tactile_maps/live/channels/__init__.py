"""Channels of readings: taxels, tare and faults.

``matching``        taxel of each value
``tare``            baseline and noise of the untouched skin, without touches meanwhile
``channel_health``  channels that never change while their neighbours do
``broken_channels`` channels whose silence is a fault
``falling_values``  values that fall where the skin seems to be touched
``shear_channels``  shear values of three-axis taxels
``channel_swaps``   pairs of channels that are probably exchanged
``last_heard``      time of the last value of each taxel and joint, and parts of the skin that repeat values
"""
