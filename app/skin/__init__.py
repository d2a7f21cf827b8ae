"""The skin: patches of taxels worn by links.

Values: ``taxels``, ``skin``. A skin comes from ``cover`` (placed by itself: ``cover_spec`` says what is wanted,
``pieces`` finds where skin can lie, ``place`` puts taxels there) or from ``exchange`` (foreign files), and is kept by
``skin_file``.
"""
