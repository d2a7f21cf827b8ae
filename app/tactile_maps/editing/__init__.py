"""Editing a map: immutable documents, edits that make new ones from them, and a history to go back and forth in.

``document`` is what is edited: a map, what a person wants of each of its patches, and the patch tree with its names,
what it hides and its order. Edits are pure functions from a document to another: ``arrange`` moves, turns, scales,
snaps and packs patches; ``layout_import`` takes over another layout of the same skin. Edits that have to be computed
(``seams``, ``pins``, and method and slider in ``reflatten``) give a request for another process, and the result is put
in later. ``history`` is undo and redo; ``document_file`` saves, loads and autosaves, and knows what has not been saved
yet.

Nothing here waits, reads a clock or knows a window: a window keeps one history, shows its present and edits it.
"""
