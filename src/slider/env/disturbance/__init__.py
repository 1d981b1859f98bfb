"""Disturbances of simulated robots: one implementation for training and evaluation."""
