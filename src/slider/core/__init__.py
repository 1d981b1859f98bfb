"""Errors, files and the protocol between a job and its stage."""
