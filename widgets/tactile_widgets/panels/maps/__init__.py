"""Panels of the map being edited: patches (with ``patch_list``, their tree), quality, comparison with another map."""
