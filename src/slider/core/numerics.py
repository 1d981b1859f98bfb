"""What the last bits of a result depend on: kernels of the libraries, torch's device, precision.

NumPy, BLAS and torch choose their kernels by the processor, so :func:`kernels` stands in the
recipes of the stages whose bytes depend on it.
"""

import importlib
import platform
from collections.abc import Mapping
from typing import Any

from slider.core.errors import UserError
from slider.core.machine import kernels, processor


def device(setting: str) -> str:
    """``cpu`` or ``cuda``; ``auto`` is cuda where torch finds one here."""
    if setting != "auto":
        return setting
    return "cuda" if _has_cuda() else "cpu"


def precision(setting: str, device: str = "cpu") -> str:
    """``bfloat16`` or ``float32``; ``auto`` is bfloat16 on a processor with instructions for it."""
    if setting != "auto":
        return setting
    fast = any(level in kernels() for level in ("amx", "avx512_bf16"))
    return "bfloat16" if fast and device == "cpu" else "float32"


def check(section: Mapping[str, Any]) -> None:
    """Compare the ``numerics`` and the device of a section with this machine.

    Raises:
        UserError: the machine has others.
    """
    expected = section.get("numerics", kernels())
    if expected != kernels():
        raise UserError(
            f"numerics: expected {expected}, as where the pipeline was started, "
            f"found {kernels()} on {platform.node()} ({processor()})"
        )
    if section.get("train", {}).get("device") == "cuda" and not _has_cuda():
        raise UserError(f"device: expected cuda, found none on {platform.node()}")


def _has_cuda() -> bool:
    return importlib.import_module("torch").cuda.is_available()
