"""Batched simulation, what agents see and do, rewards, terminations, rollouts and metrics."""
