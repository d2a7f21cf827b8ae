"""Application and main window.

``application`` opens the window on a display or for a picture; ``main_window`` creates and connects views, panels,
menus and presenters; ``toolbar`` and ``status_line`` show the state of the session.
"""
