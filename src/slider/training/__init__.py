"""Training of the standing and walking policies with PPO."""
