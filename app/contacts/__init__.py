"""Contact regions: what is touched, where on the map, where on the body.

``region`` is the value, ``reader`` finds them in taxel pressures, frame by frame.
"""
