"""Commands, limits and motion of joints.

``command``           settings and their ranges, the joint command, and the report of a task
``observation``       robot and skin at one control tick
``limits``            reasons why the arm is limited, as values
``map_kinematics``    Jacobians of the map, and distances on it across seams and links
``task_priority``     contacts and goals as rows of Jacobians, solved in order of priority
``joint_impedance``   joint impedance with the same natural frequency at any posture
``unmeasured_force``  force that the skin does not measure, from joint torques
"""
