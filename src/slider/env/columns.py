"""Columns of a reference: channels of a gait, then the motion of its base."""

from slider.robot.names import CHANNELS, NUM_JOINTS

NUM_POSITIONS = NUM_JOINTS
NUM_CHANNELS = len(CHANNELS)
BASE_HEIGHT = NUM_CHANNELS + 2
