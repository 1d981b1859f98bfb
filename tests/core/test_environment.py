"""The environment of a job: what is taken of the one around it."""

from slider.core.environment import job_environment, library_path


def test_no_folder_with_libraries_of_others_comes_first(tmp_path):
    (tmp_path / "libcasadi.so.3.7").touch()
    assert library_path(f"/a::{tmp_path}:/b") == "/a:/b"


def test_variables_are_taken_by_an_allow_list(tmp_path):
    set_by_people = {"HOME": "h", "NUMBA_DISABLE_JIT": "1", "PYTHONOPTIMIZE": "2", "LC_ALL": "C"}
    given = {"PATH": "p", "LC_TIME": "C", "CUDA_VISIBLE_DEVICES": "0"}
    found = job_environment(given | set_by_people, tmp_path)
    assert given.items() <= found.items()
    others = {"HOME", "USER", "MATPLOTLIBRC", "LC_ALL"}
    assert found.keys() == given.keys() | others
    assert found["HOME"] == str(tmp_path)
