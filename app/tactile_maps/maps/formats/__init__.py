"""Files of maps; ``export`` selects the format by suffix.

``map_file``        the format of this program: complete, and checked when it is read
``obj``             texture coordinates of a mesh, written and read
``html_page``       self-contained pages of reports
``svg``, ``png``    drawings and pictures
``unige``           robot skin library of the University of Genoa
"""
