"""Where readings come from, each a ``Source``; ``open`` chooses one by its address.

- ``files``: recorded readings: CSV and Parquet tables, CySkin text files, our own recordings.
- ``network``: UDP and ZeroMQ packets. ``serial_port``: one JSON packet a line.
- ``ros2``: messages of ROS 2, live or from a bag. ``yarp``: a YARP port, by its text-mode protocol.
"""
