"""The skin: patches of taxels worn by links.

Values: ``taxels``, ``skin``. A skin comes from ``cover`` (placed by itself: ``cover_spec`` says what is wanted,
``choose`` which links when nobody says, ``visible`` and ``pieces`` where skin can lie, ``place`` puts taxels there) or
from foreign files in ``exchange`` (``wear`` puts their taxels on a link), and is kept by ``skin_file``.
"""
