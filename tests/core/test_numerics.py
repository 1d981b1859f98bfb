"""Levels of kernels: found as libraries choose them, imposed, the same bytes where portable."""

import os
import subprocess
import sys

import numpy as np
import pytest

from slider.core import numerics
from slider.core.errors import UserError
from slider.core.numerics import check, device, impose, kernels, precision

AVX2 = "avx2 fma"
AVX512 = f"{AVX2} avx512f avx512bw avx512dq avx512vl"
BF16 = f"{AVX512} avx512_bf16"
AMX = f"{BF16} amx_tile amx_bf16"
VARIABLES = (
    *("ATEN_CPU_CAPABILITY", "ONEDNN_MAX_CPU_ISA", "DNNL_MAX_CPU_ISA", "OPENBLAS_CORETYPE"),
    *("NPY_DISABLE_CPU_FEATURES", "MKL_CBWR", "MKL_ENABLE_INSTRUCTIONS"),
)
LIMITED = {
    "ATEN_CPU_CAPABILITY": "default",
    "OPENBLAS_CORETYPE": "Prescott",
    "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR",
    "MKL_CBWR": "AVX",
}
JOB = """
import hashlib, sys
from slider.core.numerics import check, impose, kernels
chosen = kernels(sys.argv[1])
if sys.argv[1] == "portable":
    impose(chosen)
import numpy as np
import torch
torch.set_num_threads(1)
generator = torch.Generator().manual_seed(1)
x = torch.randn(96, 64, generator=generator)
net = torch.nn.Sequential(torch.nn.Linear(64, 32), torch.nn.ELU(), torch.nn.Linear(32, 4))
for weights in net.parameters():
    weights.data = 0.3 * torch.randn(weights.shape, generator=generator)
net(x).square().mean().backward()
steps = [weights.grad.numpy() for weights in net.parameters()]
base = np.random.default_rng(1).uniform(0.1, 1.0, (80, 80))
arrays = [*steps, base**7.3, np.arctan2(base, base.T), base @ base, np.linalg.inv(base)]
if sys.argv[1] == "portable":
    check(chosen)
digest = hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays))
print(digest.hexdigest(), sorted(chosen.items()))
"""
needs_avx2 = pytest.mark.skipif(
    not numerics._flags() >= numerics._AVX2, reason="no x86-64 processor with AVX2"
)


@pytest.fixture
def processor(monkeypatch):
    """Pretend to be another one, in an environment without limits."""
    for name in VARIABLES:
        monkeypatch.setenv(name, "")  # so that what a test sets is undone
        monkeypatch.delenv(name)

    def pretend(flags: str, maker: str = "GenuineIntel", **limits: str) -> None:
        found = {"flags": flags, "vendor_id": maker}
        monkeypatch.setattr(numerics, "cpuinfo", lambda field: found[field])
        monkeypatch.setattr(numerics.platform, "machine", lambda: "x86_64")
        for name, value in limits.items():
            monkeypatch.setenv(name, value)

    return pretend


@pytest.mark.parametrize(
    ("flags", "limits", "aten", "onednn"),
    [
        ("sse2", {}, "DEFAULT", "DEFAULT"),
        (AVX2, {}, "AVX2", "AVX2"),
        (AVX512, {}, "AVX512", "AVX512"),
        (BF16, {}, "AVX512", "AVX512_BF16"),
        (AMX, {}, "AVX512", "AMX"),
        (AMX, {"ATEN_CPU_CAPABILITY": "avx2"}, "AVX2", "AMX"),
        (AVX2, {"ATEN_CPU_CAPABILITY": "avx512"}, "AVX2", "AVX2"),
        (AMX, {"DNNL_MAX_CPU_ISA": "AVX2"}, "AVX512", "AVX2"),
        (AMX, {"DNNL_MAX_CPU_ISA": "AVX2", "ONEDNN_MAX_CPU_ISA": "ALL"}, "AVX512", "AMX"),
        (AMX, {"ONEDNN_MAX_CPU_ISA": "avx512_core_vnni"}, "AVX512", "AVX512"),
        (AMX, {"ONEDNN_MAX_CPU_ISA": "AVX512_CORE_FP16"}, "AVX512", "AVX512_BF16"),
        (AMX, {"ONEDNN_MAX_CPU_ISA": "AVX2_VNNI"}, "AVX512", "AVX2"),
        (AMX, {"ONEDNN_MAX_CPU_ISA": "SSE41"}, "AVX512", "DEFAULT"),
    ],
)
def test_torch_chooses_by_processor_and_environment(processor, flags, limits, aten, onednn):
    processor(flags, **limits)
    found = kernels()
    assert (found["aten"], found["onednn"]) == (aten, onednn)


def test_mkl_chooses_by_the_make_too(processor):
    processor(AVX2)
    assert kernels()["mkl"] == "GenuineIntel AVX2"
    processor(AVX2, "AuthenticAMD")
    assert kernels()["mkl"] == "AuthenticAMD AVX2"
    processor(AMX, MKL_ENABLE_INSTRUCTIONS="avx2")
    assert kernels()["mkl"] == "GenuineIntel AVX2"
    processor(AMX, MKL_CBWR="compatible")
    assert kernels()["mkl"] == "COMPATIBLE"


@pytest.mark.parametrize(
    ("flags", "found"), [(AVX2, "float32"), (AVX512, "float32"), (BF16, "bfloat16")]
)
def test_auto_is_bfloat16_where_the_processor_has_it(processor, flags, found):
    processor(flags)
    assert precision("auto", kernels()) == found
    assert precision("float32", kernels()) == "float32"
    assert precision("bfloat16", kernels()) == "bfloat16"


@pytest.fixture
def cuda(monkeypatch):
    """Pretend that torch finds a GPU, or none."""
    import torch

    return lambda there: monkeypatch.setattr(torch.cuda, "is_available", lambda: there)


@pytest.mark.parametrize(("there", "found"), [(True, "cuda"), (False, "cpu")])
def test_auto_is_the_device_that_torch_finds(cuda, there, found):
    cuda(there)
    assert device("auto") == found
    assert (device("cpu"), device("cuda")) == ("cpu", "cuda")


def test_a_device_does_not_have_the_precision_of_the_processor(processor):
    processor(AMX)
    assert precision("auto", kernels(), "cuda") == "float32"
    assert precision("bfloat16", kernels(), "cuda") == "bfloat16"


def test_a_machine_without_the_device_of_the_recipe_is_refused(cuda):
    cuda(True)
    check({"device": "cuda"})
    cuda(False)
    check({"device": "cpu"})
    with pytest.raises(UserError, match=r"^device: expected cuda, found none on "):
        check({"device": "cuda"})


def test_portable_needs_avx2_and_no_more(processor):
    processor(AMX)
    many = kernels("portable")
    processor(AVX2, "AuthenticAMD")
    assert kernels("portable") == many
    assert precision("auto", many) == "float32"
    processor("sse2 avx2")  # without fma
    with pytest.raises(UserError, match="numerics: expected an x86-64 processor with AVX2"):
        kernels("portable")


@pytest.mark.parametrize(
    ("name", "here", "message"),
    [
        ("aten", AVX2, "numerics of aten: expected AVX512, .* found AVX2 on "),
        ("onednn", AVX512, "numerics of onednn: expected AMX, .* found AVX512 on "),
        ("mkl", AVX512, "numerics of mkl: expected GenuineIntel AMX, .* GenuineIntel AVX512 on "),
    ],
)
def test_a_lower_processor_is_refused_before_anything_is_imported(processor, name, here, message):
    processor(AMX)
    expected = {name: kernels()[name]}
    impose(expected)
    processor(here)
    with pytest.raises(UserError, match=message):
        impose(expected)


def test_a_higher_processor_does_as_the_recipe_says(processor):
    processor(AVX2)
    expected = {name: kernels()[name] for name in ("aten", "mkl", "onednn")}
    processor(AMX)
    impose(expected)
    assert [os.environ[name] for name in VARIABLES[:2]] == ["avx2", "AVX2"]
    assert os.environ["MKL_ENABLE_INSTRUCTIONS"] == "AVX2"
    processor(AMX, "AuthenticAMD")
    with pytest.raises(UserError, match=r"mkl: expected GenuineIntel AVX2, .* AuthenticAMD AVX2"):
        impose(expected)


def test_other_processors_have_one_level(processor, monkeypatch):
    processor("")
    monkeypatch.setattr(numerics.platform, "machine", lambda: "arm64")
    found = kernels()
    assert {found[name] for name in ("numpy", "aten", "mkl", "onednn")} == {"arm64"}
    impose(found)
    check(found)
    assert not {*VARIABLES} & os.environ.keys()
    with pytest.raises(UserError, match="for portable"):
        kernels("portable")


def test_a_library_that_chose_otherwise_is_refused():
    assert np.__version__  # is imported: it has chosen
    found = kernels()
    check({name: found[name] for name in ("numpy", "blas")})
    with pytest.raises(UserError, match=r"numerics of blas: expected None, .* found "):
        check({"numpy": found["numpy"], "blas": "None"})
    check({})


@needs_avx2
def test_portable_has_the_same_bytes_in_a_limited_environment():
    """The recipe of ``auto`` tells where its bytes are others."""
    plain, limited = (_computed("auto", limits) for limits in ({}, LIMITED))
    assert plain[1] != limited[1]
    assert plain[0] != limited[0]
    assert _computed("portable", {}) == _computed("portable", LIMITED)


def _computed(mode: str, limits: dict[str, str]) -> tuple[str, str]:
    """Digest of arrays and of a network's gradient, and the kernels, in a process of its own."""
    environment = {name: value for name, value in os.environ.items() if name not in VARIABLES}
    done = subprocess.run(
        [sys.executable, "-c", JOB, mode],
        env=environment | limits,
        capture_output=True,
        text=True,
        check=True,
    )
    digest, _, chosen = done.stdout.strip().partition(" ")
    return digest, chosen
