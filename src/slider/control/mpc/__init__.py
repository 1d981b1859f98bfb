"""The baseline: footstep MPC on the linear inverted pendulum and a whole-body QP."""
