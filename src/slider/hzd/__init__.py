"""Hybrid zero dynamics: virtual constraints, their re-anchoring at impacts, return maps, feedback."""
