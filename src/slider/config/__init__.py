"""The resolved configuration: its types and what must hold between them.

This file imports nothing, so that a stage depends on the sections that it imports, not on all.
"""
