# What pyright infers of pandas' source are unions of all that a cell, column or row may be.
from typing import Any

def __getattr__(name: str) -> Any: ...
