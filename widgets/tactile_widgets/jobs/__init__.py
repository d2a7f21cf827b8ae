"""Background work, and work after the current event.

``executor``        runs functions in a process or inline, one after the other
``scene_jobs``      opening scenes and recordings, edits of the map
``measuring_jobs``  measurements of maps, effects and stages, and finer simulations
``skin_jobs``       links that can be covered, and skins for their preview
``recording_jobs``  reading, labelling, cutting and recording recordings
``later``           calls after the pending events
"""
