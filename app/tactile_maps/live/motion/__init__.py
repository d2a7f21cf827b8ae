"""Motion that a controller computes for a real robot from its measured skin; it is shown, and sent on request.

``measured_controller``  joint velocities from measured contacts and posture
``input_monitor``        conditions on the readings while motion is sent
``driver_channel``       connection to the robot's driver, with the conditions for sending
``motion_sender``        packets to the driver, limits, and all reasons to stop
``motion_output``        one frame in, one command or stop out
``command_loop``         threads, and the path from readings to a command
``command_latency``      time from reading to command
"""
