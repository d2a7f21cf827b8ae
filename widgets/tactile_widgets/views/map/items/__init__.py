"""What a map view shows: shapes, coordinates and colours."""
