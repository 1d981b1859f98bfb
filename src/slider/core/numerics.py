"""The kernels that NumPy, OpenBLAS and torch compute with: the last bits of a result are theirs.

A library chooses its kernels by the processor, within limits that environment variables set. The
level that each will choose is found when jobs are laid out, and stands in recipes. A job makes its
libraries choose just that, or refuses.
"""

import importlib
import os
import platform
import sys
from collections.abc import Mapping
from typing import Literal

from slider.core.errors import UserError
from slider.core.machine import cpuinfo, processor

AUTO = "auto"
Mode = Literal["auto", "portable"]
Kernels = dict[str, str]
"""Library → level of its kernels."""

_AVX2 = frozenset({"avx2", "fma"})
_AVX512 = _AVX2 | {"avx512f", "avx512bw", "avx512dq", "avx512vl"}
_LEVELS = {  # of processors, highest first, with the flags that they have
    "AMX": _AVX512 | {"avx512_bf16", "amx_tile", "amx_bf16"},
    "AVX512_BF16": _AVX512 | {"avx512_bf16"},
    "AVX512": _AVX512,
    "AVX2": _AVX2,
    "DEFAULT": frozenset[str](),
}
_NUMPY = {  # its own names, by release; it has more, but none whose numbers differ
    "AVX512": ("X86_V4", "AVX512_SKX", "AVX512F"),
    "AVX2": ("X86_V3", "AVX2", "FMA3"),
}
_NUMPY_OTHERS = ("AVX512CD", "AVX512_CLX", "AVX512_CNL", "AVX512_ICL", "AVX512_SPR")
_BLAS = {"AVX512": ("SkylakeX", "Cooperlake", "SapphireRapids"), "AVX2": ("Haswell", "Zen")}
_ONEDNN = {
    "AMX": "AVX512_CORE_AMX",
    "AVX512_BF16": "AVX512_CORE_BF16",
    "AVX512": "AVX512_CORE",
    "AVX2": "AVX2",
    "DEFAULT": "SSE41",
}
_BFLOAT16 = ("AMX", "AVX512_BF16")
_PORTABLE: Kernels = {
    **dict.fromkeys(("numpy", "blas", "aten", "onednn"), "AVX2"),
    "mkl": "COMPATIBLE",  # the only kernels that MKL has for all makes
}


def kernels(mode: Mode = AUTO) -> Kernels:
    """What each library chooses here or, ``portable``, what every x86-64 processor with AVX2 can.

    Raises:
        UserError: ``portable``, and the processor has no AVX2.
    """
    if mode == AUTO:
        return _by_processor() | _by_report()
    if not _flags() >= _AVX2:
        expected = "an x86-64 processor with AVX2 for portable"
        raise UserError(f"numerics: expected {expected}, found {processor()}")
    return _PORTABLE


def device(wanted: str) -> str:
    """``cpu`` or ``cuda``; ``auto`` is cuda where torch finds one here."""
    if wanted != AUTO:
        return wanted
    return "cuda" if _has_cuda() else "cpu"


def precision(wanted: str, chosen: Mapping[str, str], device: str = "cpu") -> str:
    """``bfloat16`` or ``float32``; ``auto`` is bfloat16 where oneDNN has fast kernels for it."""
    if wanted != AUTO:
        return wanted
    if device != "cpu":  # whoever lays out the jobs need not have one
        return "float32"
    return "bfloat16" if chosen["onednn"] in _BFLOAT16 else "float32"


def impose(expected: Mapping[str, str]) -> None:
    """Make libraries that are not yet imported choose these kernels.

    Raises:
        UserError: the processor lacks them.
    """
    if _is_x86():
        os.environ.update(_variables(expected))
    _compare(expected, _by_processor())


def check(expected: Mapping[str, str]) -> None:
    """Ask the libraries, now imported, for their choice.

    Raises:
        UserError: it is another one.
    """
    if not expected:
        return
    if expected.get("device") == "cuda" and not _has_cuda():
        raise UserError(f"device: expected cuda, found none on {platform.node()}")
    found = _by_report()
    if _is_x86() and "torch" in sys.modules:
        found["aten"] = sys.modules["torch"].backends.cpu.get_cpu_capability()
    _compare(expected, found)


def _has_cuda() -> bool:
    return importlib.import_module("torch").cuda.is_available()


def _compare(expected: Mapping[str, str], found: Mapping[str, str]) -> None:
    for name in expected:
        if name in found and found[name] != expected[name]:
            raise UserError(
                f"numerics of {name}: expected {expected[name]}, as where the pipeline was "
                f"started, found {found[name]} on {platform.node()} ({processor()})"
            )


def _variables(expected: Mapping[str, str]) -> dict[str, str]:
    """Environment in which the libraries choose these kernels, where the processor has them."""
    found: dict[str, str] = {}
    if "numpy" in expected:
        levels = list(_LEVELS)
        above = levels[: levels.index(expected["numpy"])]
        others = [name for level in above for name in _NUMPY.get(level, ())]
        found["NPY_DISABLE_CPU_FEATURES"] = " ".join((*others, *_NUMPY_OTHERS))
    if "blas" in expected:
        found["OPENBLAS_CORETYPE"] = _BLAS.get(expected["blas"], (expected["blas"],))[0]
    if "aten" in expected:
        found["ATEN_CPU_CAPABILITY"] = expected["aten"].lower()
    if "onednn" in expected:
        found["ONEDNN_MAX_CPU_ISA"] = _ONEDNN[expected["onednn"]]
    if expected.get("mkl") == _PORTABLE["mkl"]:
        found["MKL_CBWR"] = expected["mkl"]
    level = expected.get("mkl", "").rpartition(" ")[2]
    if level in ("AVX2", "AVX512"):  # where there is more, MKL has names of its own
        found["MKL_ENABLE_INSTRUCTIONS"] = level
    return found


def _by_processor() -> Kernels:
    """Of torch's libraries, as they choose: to import torch takes a second."""
    if not _is_x86():
        return dict.fromkeys(("aten", "mkl", "onednn"), platform.machine())
    level = next(name for name, needs in _LEVELS.items() if needs <= _flags())
    onednn = os.environ.get("ONEDNN_MAX_CPU_ISA", os.environ.get("DNNL_MAX_CPU_ISA", ""))
    return {
        "aten": _lowest(level, "AVX512", os.environ.get("ATEN_CPU_CAPABILITY", "").upper()),
        "mkl": _mkl(level),
        "onednn": _lowest(level, _onednn(onednn.upper())),
    }


def _lowest(*levels: str) -> str:
    """The lowest of some levels; another word is no limit, as for the libraries."""
    return max((name for name in levels if name in _LEVELS), key=list(_LEVELS).index)


def _onednn(limit: str) -> str:
    """Level of a value of oneDNN's variable."""
    if "AMX" in limit:
        return "AMX"
    if limit in ("AVX512_CORE_BF16", "AVX512_CORE_FP16", "AVX10_1_512"):
        return "AVX512_BF16"
    if limit in ("SSE41", "AVX"):
        return "DEFAULT"
    return limit.partition("_")[0]


def _mkl(level: str) -> str:
    """MKL has fewer kernels for processors that are not Intel's."""
    branch = os.environ.get("MKL_CBWR", "").upper()
    if branch not in ("", "AUTO", "OFF"):
        return branch
    return f"{cpuinfo('vendor_id')} {os.environ.get('MKL_ENABLE_INSTRUCTIONS', level).upper()}"


def _by_report() -> Kernels:
    """Of NumPy, as ``numpy.show_runtime`` finds it, and of each OpenBLAS: SciPy has its own."""
    from threadpoolctl import threadpool_info

    core = importlib.import_module("numpy._core._multiarray_umath")  # first: it brings its BLAS
    on = [name for name in core.__cpu_dispatch__ if core.__cpu_features__[name]]
    if _is_x86():
        numpy = next((level for level, names in _NUMPY.items() if {*names} & {*on}), "DEFAULT")
    else:
        numpy = platform.machine()
    cores = {lib.get("architecture", "") for lib in threadpool_info() if lib["user_api"] == "blas"}
    blas = {next((lv for lv, names in _BLAS.items() if core in names), core) for core in cores}
    return {"numpy": numpy, "blas": " ".join(sorted(blas))}


def _is_x86() -> bool:
    return platform.machine() == "x86_64"


def _flags() -> set[str]:
    return set(cpuinfo("flags").split())
