"""Extended hybrid zero dynamics: one periodic walk per commanded velocity."""
