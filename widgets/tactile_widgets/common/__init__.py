"""Shared parts of the window: colours and themes, settings, kinds of tools and files, small widgets.

``colours``              themes, and the scales of pressure and distortion; ``application_theme`` applies a theme
``settings``             settings stored between launches
``controller_settings``  texts and sliders of the settings of controllers
``tool_kinds``           tools as the views know them; ``mode`` the modes of the window
``file_dialogs``         file dialogs, their filters, and the files that the window opens
``panel``                base class of panels and their parts; ``number_field`` and ``guide_window`` are widgets
``dialog_icons``         icons of dialogs and their buttons; ``sentence`` error messages as sentences
``make``                 constructors of Qt objects; ``lists`` shared parts of lists, ``note_list`` lists of notes
"""
