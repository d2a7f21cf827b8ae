"""The tactile map: charts, interpolation, images, Jacobians and transitions across seams."""
