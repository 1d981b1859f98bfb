"""The resolved configuration: typed, checked, composed by Hydra from ``conf/``.

This file imports nothing, so that a stage depends on the sections that it imports, not on all.
"""
