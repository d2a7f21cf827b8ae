"""Motion that a controller computes for a real robot from its measured skin, shown, and sent after a user's action.

- ``measured_controller``: joint velocities from measured contacts and posture.
- ``input_monitor``: what must hold of the readings while motion is sent.
- ``driver_channel``: the connection to the robot's driver, and what must hold before motion is sent.
- ``motion_sender``: packets to the robot's driver, limits, and every reason to stop.
- ``motion_output``: one frame in, one command or stop out.
- ``command_loop``: the threads, and the pass from readings to a command.
- ``command_latency``: how long commands take.
"""
