"""Canvas items of the map: shapes, coordinates and colours."""
