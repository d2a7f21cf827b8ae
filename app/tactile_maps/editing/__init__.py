"""Editing a map: immutable documents, functions that return changed documents, and their history.

``document``       a map with the settings of each patch, and the patch tree with names, hidden patches and order
``arrange``        moves, turns, scales, snaps and packs patches
``seams``, ``pins``, ``reflatten``  edits that are computed in another process: a request, and its result
``layout_import``  takes the layout of another map of the same skin
``history``        undo and redo
``document_file``  saves, loads and autosaves a document, and records what is unsaved
``leftovers``      unsaved edits that a crash left

Nothing here waits, reads a clock or depends on a window. A window keeps one history, shows its document and changes it.
"""
