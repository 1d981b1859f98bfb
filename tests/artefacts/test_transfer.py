"""Results that travel: what arrives is whole, of the same inputs, and damage stays where it is."""

from functools import partial

import pytest

from slider.artefacts.maintenance import verify
from slider.artefacts.plan import write_plan
from slider.artefacts.remote import Remote
from slider.artefacts.store import Store, exclusive
from slider.artefacts.transfer import TransferReport, pull, push
from slider.cli import main
from slider.core import files
from tests.artefacts.samples import (
    GAITS,
    JOBS,
    LIBRARY,
    PLAN,
    TABLE,
    compute,
    contents,
    damage,
    data,
)
from tests.artefacts.servers import KINDS, anywhere, http_server
from tests.faults.chain import process
from tests.faults.operations import kill_at


@pytest.mark.parametrize("kind", KINDS)
def test_another_store_is_the_same_afterwards(kind, full, bare, tmp_path):
    with anywhere(kind, tmp_path) as remote:
        sent = push(full, JOBS, remote)
        assert (sent.counts, sent.damage) == ({"uploaded": 8}, [])
        assert push(full, JOBS, remote).counts == {"already in the remote": 8}
        assert push(full, JOBS, remote, force=True).counts == {"uploaded": 8}
        taken = pull(bare, JOBS, remote)
        assert taken.counts == {"fetched": 8}
        assert contents(bare) == contents(full)
        metadata = files.read_json(bare.metadata_path("table1", TABLE.recipe))
        assert metadata == {"wall_s": 2.5, "computed": False, "taken_from": remote.url}
        assert pull(bare, JOBS, remote) == TransferReport()
        assert verify(bare) == []
    times = [bare.manifest_path(j.stage, j.recipe).stat().st_mtime_ns for j in JOBS.values()]
    assert times == sorted(times), "Snakemake compares them"


def test_http_is_enough_to_read(filled, full, bare):
    with http_server(filled.folder) as url:
        assert pull(bare, JOBS, Remote(url)).counts == {"fetched": 8}
    assert contents(bare) == contents(full)


def test_a_result_waits_for_its_inputs(filled, full, bare):
    """Until these are there, byte for byte, the index alone knows it."""
    lost = filled.result(GAITS[0])
    lost.unlink()
    expected = {"missing in the remote": 1, "fetched": 5, "waiting for inputs": 2}
    assert pull(bare, JOBS, filled.remote).counts == expected
    assert not bare.manifest_path("library", LIBRARY.recipe).exists()
    compute(bare, GAITS[0])
    objects = {"gaits": [bare.read_manifest("gait", g.recipe).result.object for g in GAITS]}
    assert bare.find(LIBRARY.key(objects)) == full.read_manifest("library", LIBRARY.recipe)
    assert bare.metadata("library", LIBRARY.recipe)["wall_s"] == 2.5  # for whoever reuses it
    assert pull(bare, JOBS, filled.remote).counts == {"fetched": 2}


def test_results_of_two_machines_do_not_mix(filled, bare):
    """A library of other gaits is none for those that are here."""
    compute(bare, GAITS[0], "of another machine")
    assert pull(bare, JOBS, filled.remote).counts == {"fetched": 5, "waiting for inputs": 2}
    compute(bare, LIBRARY)
    compute(bare, TABLE)
    before = filled.result(GAITS[0]).read_bytes()
    assert push(bare, JOBS, filled.remote).counts == {
        "different in the remote": 1,
        "already in the remote": 7,
    }
    assert filled.result(GAITS[0]).read_bytes() == before


def test_a_job_that_runs_meanwhile_wins(filled, full, bare, monkeypatch):
    """One gait is computed while the pull is on its way, another is still being computed."""
    read, own = Remote.read, []

    def compute_first(remote: Remote, name: str, limit: int):
        if GAITS[0].recipe in name:
            own.append(compute(bare, GAITS[0], "of another machine"))
        return read(remote, name, limit)

    monkeypatch.setattr(Remote, "read", compute_first)
    with exclusive(bare.locks, GAITS[1].recipe):
        found = pull(bare, JOBS, filled.remote)
    assert found.counts == {"computed here": 2, "fetched": 4, "waiting for inputs": 2}
    assert bare.read_manifest("gait", GAITS[0].recipe) == own[0]
    assert bare.metadata("gait", GAITS[0].recipe) == {"wall_s": 2.5}
    assert not bare.manifest_path("gait", GAITS[1].recipe).exists()


def test_what_is_damaged_here_stays_here(place, full, bare):
    damage(data(full, full.read_manifest("gait", GAITS[0].recipe)))
    found = push(full, JOBS, place.remote)
    assert found.counts == {"damaged": 1, "uploaded": 7}
    (line,) = found.damage
    assert line.endswith("damaged here: run `slider store verify`")
    compute(bare, GAITS[0])
    push(bare, JOBS, place.remote)
    assert pull(full, JOBS, place.remote).counts == {"fetched": 1}
    assert verify(full) == []


def words(store: Store, *arguments: str) -> list[str]:
    """Of a command about a store with a plan."""
    write_plan(PLAN, store.root / "plans")
    return ["store", "--artefacts", str(store.root), *arguments]


def command(store: Store, *arguments: str) -> int:
    return main(words(store, *arguments))


@pytest.mark.parametrize(("action", "moment"), [("push", 1), ("push", 33), ("pull", 33)])
def test_a_killed_push_or_pull_goes_on(action, moment, place, full, bare):
    """Before its n-th operation on a file."""
    store = full if action == "push" else bare
    if action == "pull":
        push(full, JOBS, place.remote)
    run = partial(command, store, action, place.remote.url)
    assert process(run, kill_at(store.root.parent, moment)).status == -9
    assert verify(store) == []
    assert run() == 0
    pull(bare, JOBS, place.remote)
    assert contents(bare) == contents(full)


def test_the_command_says_what_travelled(place, full, bare, capsys):
    url = place.remote.url
    assert command(full, "push", url, "library") == 0
    assert capsys.readouterr().out.startswith(f"push to {url}: 7 uploaded (0.0 MB) in ")
    assert command(full, "push", url, "--all") == 0
    damage(place.file(full, TABLE))
    assert command(bare, "pull", url) == 1
    assert capsys.readouterr().err.startswith(f"table ({TABLE.recipe[:12]}): damaged in {url}: ")
    assert command(full, "push", url, "--force") == 0
    assert command(bare, "pull", url) == 0


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["push", "REMOTE", "report"], "target: expected one of library, table1, found report"),
        (["pull", "REMOTE"], "expected results of slider, found none"),
        (["push", "REMOTE/deep/folder"], "No such file or directory"),
        (["push", "https://127.0.0.1:1/x"], "expected one to write to, found HTTP"),
        (["pull", "sftp://me:secret@host/x"], "expected a remote without a password"),
    ],
)
def test_bad_input_is_one_line(arguments, text, place, bare, refused):
    given = [word.replace("REMOTE", place.remote.url) for word in arguments]
    assert text in refused(*words(bare, *given))
    assert not place.folder.exists()
