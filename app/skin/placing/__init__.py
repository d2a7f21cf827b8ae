"""Taxels placed by themselves on a surface: evenly, by a density, as a hexagonal lattice, or in triangular modules.

Read ``place`` first, then a pattern: ``lattice`` (hexagonal), ``modules``; ``density`` says where taxels lie closer,
``keep_out`` where none may lie. What a person asks for is in ``app.skin.placement_spec``; the even pattern is
``app.skin.place``.
"""
