"""Joints and drives of a leg from hip to foot: keys of the robot's parameters."""

LEG_JOINTS = ("hip_yaw", "hip_roll", "hip_pitch", "slide", "ankle", "upper_foot")
LEG_DRIVES = ("hip_yaw", "hip_roll", "hip_pitch", "capstan")  # one per hip joint; slide and ankle
