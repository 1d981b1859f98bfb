"""What ``slider runs`` needs; its pages are looked at in tests/browser."""

import pytest

from slider.cli import main


@pytest.mark.parametrize("content", [None, b"", b"no database"])
def test_without_runs_it_is_one_line(tmp_path, capsys, content):
    if content is not None:
        (tmp_path / "mlflow.db").write_bytes(content)
    assert main(["runs", "--artefacts", str(tmp_path)]) == 1
    text = capsys.readouterr().err
    assert text.startswith("slider: expected runs in ")
    assert len(text.splitlines()) == 1
    assert not (tmp_path / "mlflow.db").exists() or (tmp_path / "mlflow.db").read_bytes() == content
