"""Runs in MLflow, through journals."""
