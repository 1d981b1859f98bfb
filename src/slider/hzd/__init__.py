"""Hybrid zero dynamics: virtual constraints, return maps and feedback from step to step."""
