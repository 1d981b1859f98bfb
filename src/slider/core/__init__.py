"""Errors, files and the interface between a job and its stage."""
