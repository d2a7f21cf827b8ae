"""Contact regions: what is touched, where on the map and on the body. ``region`` is the value, ``reader`` finds them."""
