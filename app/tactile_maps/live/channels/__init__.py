"""From the channels of a reading to pressures of taxels, and which channels to doubt.

- ``matching``: which taxel each value is of.
- ``calibration``: what pressure a value means; ``weighing``: by a known weight that lies on the skin.
- ``channel_health``: which channels never change; ``channel_swaps``: which stand in each other's place.
- ``last_heard``: when each taxel and joint was last heard, and which parts of the skin repeat the same values.
"""
