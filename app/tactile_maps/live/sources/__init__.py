"""Sources of readings; ``open`` selects one by its address.

``files``        recorded readings: CSV and Parquet tables, CySkin text files, recordings of this program
``network``      UDP and ZeroMQ packets; ``one_sender`` admits those of one sender at a time
``serial_port``  JSON packets, one on each line
``ros2``         messages of ROS 2, live or from a bag
``yarp``         a YARP port with its text-mode protocol
``send``         example of a sender
"""
