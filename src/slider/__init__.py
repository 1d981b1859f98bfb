"""Extended hybrid zero dynamics gaits and guided reinforcement learning for SLIDER."""
