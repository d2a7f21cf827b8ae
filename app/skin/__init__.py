"""The skin: patches of taxels worn by links.

Values: ``taxels``, ``skin``. A skin comes from ``cover`` (placed by itself: ``cover_spec`` says what is wanted,
``choose`` which links when nobody says, ``visible`` and ``pieces`` where skin can lie, ``place`` puts taxels there),
from a ``bare`` mesh (``placement_spec`` says what is wanted, ``placing`` has the patterns), from foreign files in
``exchange`` (``wear`` puts their taxels on a link), or from taxels alone (``from_taxels``: ``normals`` and
``triangulate`` lay a surface through them, ``rim`` widens it). It is kept by ``skin_file``.
"""
