"""A skin: taxels on a surface, its file, and the surface that it leaves bare."""
