"""The application and its main window.

``application`` starts it, on a display or for a picture; ``main_window`` puts views, panels, menus and presenters
together and decides nothing; ``toolbar`` shows the state of the session.
"""
