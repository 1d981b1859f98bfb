"""Reports are copied whole or not at all."""

import pytest

from slider.artefacts.manifest import Manifest
from slider.artefacts.store import Store
from slider.cli import main


@pytest.mark.parametrize("damaged", [False, True])
def test_a_copy_is_what_the_manifest_says(tmp_path, capsys, damaged):
    store, report = Store(tmp_path / "artefacts"), tmp_path / "reports" / "table1.csv"
    with store.temporary("test") as out:
        (out / "table1.csv").write_text("mse\n0.0285\n")
        result = store.publish(out, {})
    manifest = Manifest("table1", "0" * 64, {}, result)
    store.write_manifest(manifest)
    report.parent.mkdir()
    report.write_text("the one before")
    if damaged:
        source = store.object_folder(result.object) / "table1.csv"
        source.chmod(0o644)
        source.write_text("mse\n0.0485\n")
    path = store.manifest_path("table1", manifest.recipe)
    arguments = ["publish", str(path), str(report), "--artefacts", str(store.root)]
    assert main(arguments) == int(damaged)
    assert report.read_text() == ("the one before" if damaged else "mse\n0.0285\n")
    assert [*report.parent.iterdir()] == [report]
    error = capsys.readouterr().err
    assert ("found it damaged: run `slider store verify`" in error) is damaged
