"""Background work: ``executor`` runs functions in a process or inline, ``recording_jobs`` has those of recordings."""
