"""Walking by hybrid zero dynamics: the library's virtual constraints, enforced without learning."""
