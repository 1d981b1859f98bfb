"""The library of an array: numpy's functions or torch's, where both have the same."""

import sys
from typing import Any

import numpy as np


def namespace(array: Any) -> Any:
    """numpy of an array, torch of a tensor, which has imported it."""
    return np if isinstance(array, np.ndarray) else sys.modules[type(array).__module__]
