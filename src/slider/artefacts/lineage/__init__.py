"""Where results come from, how two of them differ, and why one would be computed again.

Pure functions on stores and plans: nothing here writes.
"""
