"""Hybrid zero dynamics: virtual constraints, re-anchoring at impacts, return maps, feedback."""
