"""Editing a map: immutable documents, edits that make new ones from them, and a history to go back and forth in.

``document`` is what is edited: a map and what a person wants of each of its patches. Edits are pure functions from a
document to another: ``arrange`` moves, turns, scales and packs patches, with ``snap`` for the hand; ``patches`` names,
hides and orders them. Edits that have to be computed (``seams``, ``pins``, and method and slider in ``reflatten``) give
a request for another process, and the result is put in later. ``history`` is undo and redo; ``document_file`` saves and
loads, and ``autosave`` knows what has not been saved yet.

Nothing here waits, reads a clock or knows a window: a window keeps one history, shows its present and edits it.
"""
