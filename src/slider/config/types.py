"""Settings of all configuration classes: unknown keys and wrong types are refused."""

from pydantic import ConfigDict

STRICT = ConfigDict(extra="forbid", strict=True)

Vector3 = tuple[float, float, float]
