"""Compiled functions: the same bits, made once; without them all goes on."""

import shutil
import stat
from dataclasses import replace
from pathlib import Path

import casadi as ca
import pytest

from slider.core.job import Job
from slider.gait.compiled import WORTH, Compiled
from slider.gait.problem import Functions
from tests.gait.gaits import form

needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
FORM = form()


def small() -> Functions:
    x, y = ca.SX.sym("x", 3), ca.SX.sym("y")
    rows = ca.sin(x) * y + x / (y + 3)
    value, slope = ca.Function("f", [x, y], [rows]), ca.jacobian(rows, x)
    return {"f": value, "f_jacobian": ca.Function("f_jacobian", [x, y], [slope])}


def never() -> Functions:
    raise AssertionError("expected the compiled functions")


def compiled(folder: Path, waiting: int = WORTH, run: str = "a run") -> Compiled:
    facts = {"pipeline_started": run}
    return Compiled(Job(folder, volatile=facts, cache=folder / "cache", waiting=waiting))


def libraries(folder: Path) -> list[Path]:
    return sorted((folder / "cache").glob("*.so"))


def is_compiled(functions: Functions) -> bool:
    return all(str(function).endswith("External") for function in functions.values())


@pytest.fixture
def compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Puts a shell script in the place of the C compiler."""

    def put(lines: str) -> None:
        script = tmp_path / "compiler"
        script.write_text(f"#!/bin/sh\necho call >> {tmp_path}/calls\n{lines}\n")
        script.chmod(script.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv("CC", str(script))

    return put


@needs_compiler
def test_the_first_job_compiles_and_the_others_load(tmp_path: Path):
    first = compiled(tmp_path)(FORM, small)
    later = compiled(tmp_path, waiting=1)(FORM, never)
    assert is_compiled(first)
    assert is_compiled(later)
    for name, function in small().items():
        given = [[0.3, -0.7, 2.0], 0.4]
        expected, found = function(*given).full(), later[name](*given).full()
        assert expected.tobytes() == found.tobytes()


def test_few_gaits_are_not_worth_it(tmp_path: Path):
    assert not is_compiled(compiled(tmp_path, WORTH - 1)(FORM, small))
    assert not libraries(tmp_path)


def test_a_stage_without_a_cache_derives():
    assert not is_compiled(Compiled(Job(Path(), waiting=WORTH))(FORM, small))


@needs_compiler
@pytest.mark.parametrize(
    "text",
    ["sin(/cos(", r"sin(\([^)]*\))/sin(fabs(\1))"],
    ids=["everywhere", "of negative arguments"],
)
def test_a_compiler_that_changes_bits_is_called_once(tmp_path: Path, compiler, text: str):
    compiler(f"for last; do case $last in *.c) sed -i 's/{text}/' $last;; esac; done; cc \"$@\"")
    for run in ("first", "second"):
        assert not is_compiled(compiled(tmp_path, run=run)(FORM, small))
    assert (tmp_path / "calls").read_text() == "call\n"
    assert not libraries(tmp_path)


@needs_compiler
def test_a_failed_compilation_is_tried_again_by_the_next_run_alone(tmp_path: Path, compiler):
    compiler("exit 1")
    for _ in range(2):
        assert not is_compiled(compiled(tmp_path, run="first")(FORM, small))
    assert (tmp_path / "calls").read_text() == "call\n"
    compiler('cc "$@"')
    assert is_compiled(compiled(tmp_path, run="second")(FORM, small))


@needs_compiler
def test_a_compiler_may_be_several_words(tmp_path: Path, monkeypatch):
    monkeypatch.setenv("CC", "env cc")
    assert is_compiled(compiled(tmp_path)(FORM, small))


@needs_compiler
def test_a_result_that_is_no_number_is_no_difference(tmp_path: Path):
    def root() -> Functions:
        x = ca.SX.sym("x", 3)
        return {"f": ca.Function("f", [x], [ca.sqrt(x)])}

    assert is_compiled(compiled(tmp_path)(FORM, root))


@needs_compiler
def test_a_machine_without_a_compiler_decides_for_no_other(tmp_path: Path, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    assert not is_compiled(compiled(tmp_path)(FORM, small))
    monkeypatch.delenv("CC")
    assert is_compiled(compiled(tmp_path)(FORM, small))


@needs_compiler
def test_a_damaged_library_is_not_loaded_but_compiled_again(tmp_path: Path):
    compiled(tmp_path)(FORM, small)
    (library,) = libraries(tmp_path)
    whole = library.read_bytes()
    library.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
    assert not is_compiled(compiled(tmp_path, waiting=1)(FORM, small))
    assert is_compiled(compiled(tmp_path)(FORM, small))
    assert is_compiled(compiled(tmp_path, waiting=1)(FORM, never))


@needs_compiler
def test_other_formulations_have_other_functions_but_a_bound_has_none(tmp_path: Path):
    compiled(tmp_path)(FORM, small)
    compiled(tmp_path)(replace(FORM, turning=True), small)
    assert len(libraries(tmp_path)) == 2
    by_hip = [replace(FORM, config=replace(FORM.config, phase="hip"), hip_rate=r) for r in (1, 2)]
    for one in by_hip:
        compiled(tmp_path)(one, small)
    assert len(libraries(tmp_path)) == 3
