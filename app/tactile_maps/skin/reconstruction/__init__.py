"""A surface for taxels that come without one: triangles, normals, a boundary that is extended."""
