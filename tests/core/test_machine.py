"""Kernels by processor, device and precision as recipes hold them, and refusal elsewhere."""

import pytest

from slider.core import machine
from slider.core.errors import UserError
from slider.core.machine import check_machine, device, kernels, precision

AVX2 = "sse2 avx2 fma"
AVX512 = f"{AVX2} avx512f avx512bw avx512dq avx512vl"
BF16 = f"{AVX512} avx512_bf16"
AMX = f"{BF16} amx_tile amx_bf16"


@pytest.fixture
def cuda(monkeypatch):
    """Pretend that torch finds a GPU, or none."""
    import torch

    return lambda there: monkeypatch.setattr(torch.cuda, "is_available", lambda: there)


@pytest.mark.parametrize(
    ("flags", "maker", "name", "auto"),
    [
        ("sse2 avx2", "GenuineIntel", "x86_64-sse-intel", "float32"),  # without fma
        (AVX2, "AuthenticAMD", "x86_64-avx2-amd", "float32"),
        (BF16, "AuthenticAMD", "x86_64-avx512_bf16-amd", "bfloat16"),
        (AMX, "GenuineIntel", "x86_64-amx-intel", "bfloat16"),
        ("", "", "arm64", "float32"),
    ],
)
def test_kernels_and_precision_follow_the_processor(processor, flags, maker, name, auto):
    processor(flags, maker, name.partition("-")[0])
    assert kernels() == name
    assert precision("auto") == auto
    assert precision("auto", "cuda") == "float32"
    assert (precision("float32"), precision("bfloat16", "cuda")) == ("float32", "bfloat16")


@pytest.mark.parametrize(
    ("text", "found"), [("150000 100000\n", 2), ("900000 100000", 5), ("max 100000\n", 5)]
)
def test_cores_are_those_of_affinity_and_quota(text, found, tmp_path, monkeypatch):
    monkeypatch.setattr(machine.os, "sched_getaffinity", lambda _: range(5))
    monkeypatch.setattr(machine, "_QUOTA", tmp_path / "cpu.max")
    assert machine.cores() == 5
    (tmp_path / "cpu.max").write_text(text)
    assert machine.cores() == found


def test_a_job_of_another_machine_is_refused(processor):
    processor(AMX)
    section = {"numerics": kernels()}
    check_machine(section)
    check_machine({})
    processor(AVX2)
    expected = r"^numerics: expected x86_64-amx-intel, .* found x86_64-avx2-intel on .*\(any\)$"
    with pytest.raises(UserError, match=expected):
        check_machine(section)


def test_auto_is_the_device_that_torch_finds_and_a_missing_one_is_refused(cuda):
    section = {"train": {"device": "cuda"}}
    cuda(True)
    assert (device("auto"), device("cpu")) == ("cuda", "cpu")
    check_machine(section)
    cuda(False)
    assert (device("auto"), device("cuda")) == ("cpu", "cuda")
    check_machine({"train": {"device": "cpu"}})
    with pytest.raises(UserError, match=r"^device: expected cuda, found none on "):
        check_machine(section)
