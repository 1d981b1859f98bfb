"""Results that travel: what arrives is whole, of the same inputs, and damage stays where it is."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from slider.artefacts.maintenance import Removed, verify
from slider.artefacts.plan import JobSpec, write_plan
from slider.artefacts.remote import Remote
from slider.artefacts.sharing import Account, pull, push
from slider.artefacts.store import Store, exclusive
from slider.cli import main
from slider.core import files
from tests.artefacts.samples import GAITS, LIBRARY, PLAN, TABLE, compute, damage, data, fill, forge
from tests.artefacts.servers import KINDS, anywhere, http_server
from tests.faults.chain import process
from tests.faults.operations import kill_at

JOBS = dict(PLAN.jobs)


@dataclass(frozen=True)
class Place:
    """One remote with its files on this machine."""

    remote: Remote
    folder: Path

    def file(self, store: Store, job: JobSpec) -> Path:
        """The file of a result that no other has."""
        path = data(store, store.read_manifest(job.stage, job.recipe))
        return self.folder / "files" / files.digest_file(path)

    def result(self, job: JobSpec) -> Path:
        return self.folder / "results" / f"{job.recipe}.json"


@pytest.fixture
def full(tmp_path: Path) -> Store:
    """A store in which everything is computed."""
    return fill(Store(tmp_path / "full"))


@pytest.fixture
def bare(tmp_path: Path) -> Store:
    return Store(tmp_path / "bare")


@pytest.fixture
def place(tmp_path: Path) -> Place:
    return Place(Remote(str(tmp_path / "remote")), tmp_path / "remote")


@pytest.fixture
def filled(place: Place, full: Store) -> Place:
    push(full, JOBS, place.remote)
    return place


def contents(store: Store) -> dict[str, Any]:
    """Objects, manifests and index of a store, without what a killed process left."""
    names = ("objects/??/*/**/*", "gait/*", "library/*", "table1/*", "index/*/*")
    paths = [path for name in names for path in store.root.glob(name) if path.is_file()]
    found = {path.relative_to(store.root).as_posix(): path.read_bytes() for path in paths}
    ends = (".part", ".run.json")
    return {name: content for name, content in found.items() if not name.endswith(ends)}


@pytest.mark.parametrize("kind", KINDS)
def test_another_store_is_the_same_afterwards(kind, full, bare, tmp_path):
    with anywhere(kind, tmp_path) as remote:
        sent = push(full, JOBS, remote)
        assert (sent.counts, sent.damage) == ({"sent": 8}, [])
        assert push(full, JOBS, remote).counts == {"already there": 8}
        assert push(full, JOBS, remote, verify=True).counts == {"already there": 8}
        taken = pull(bare, JOBS, remote)
        assert taken.counts == {"taken": 8}
        assert contents(bare) == contents(full)
        facts = files.read_json(bare.sidecar_path("table1", TABLE.recipe))
        assert facts == {"wall_s": 2.5, "computed": False, "taken_from": remote.url}
        assert pull(bare, JOBS, remote) == Account()
        assert verify(bare) == Removed([], [])
    times = [bare.manifest_path(j.stage, j.recipe).stat().st_mtime_ns for j in JOBS.values()]
    assert times == sorted(times), "Snakemake compares them"


def test_http_is_enough_to_read(filled, full, bare):
    with http_server(filled.folder) as url:
        assert pull(bare, JOBS, Remote(url)).counts == {"taken": 8}
    assert contents(bare) == contents(full)


def test_a_result_waits_for_its_inputs(filled, full, bare):
    """Until these are there, byte for byte, the index alone knows it."""
    lost = filled.result(GAITS[0])
    lost.unlink()
    expected = {"not there": 1, "taken": 5, "of other inputs": 2}
    assert pull(bare, JOBS, filled.remote).counts == expected
    assert not bare.manifest_path("library", LIBRARY.recipe).exists()
    compute(bare, GAITS[0])
    objects = {"gaits": [bare.read_manifest("gait", g.recipe).result.object for g in GAITS]}
    assert bare.indexed(LIBRARY.key(objects)) == full.read_manifest("library", LIBRARY.recipe)
    assert bare.facts("library", LIBRARY.recipe)["wall_s"] == 2.5  # for whoever reuses it
    assert pull(bare, JOBS, filled.remote).counts == {"taken": 2}


def test_results_of_two_machines_do_not_mix(filled, bare):
    """A library of other gaits is none for those that are here."""
    compute(bare, GAITS[0], "of another machine")
    assert pull(bare, JOBS, filled.remote).counts == {"taken": 5, "of other inputs": 2}
    compute(bare, LIBRARY)
    compute(bare, TABLE)
    before = filled.result(GAITS[0]).read_bytes()
    assert push(bare, JOBS, filled.remote).counts == {"different there": 1, "already there": 7}
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
    assert found.counts == {"computed here": 2, "taken": 4, "of other inputs": 2}
    assert bare.read_manifest("gait", GAITS[0].recipe) == own[0]
    assert bare.facts("gait", GAITS[0].recipe) == {"wall_s": 2.5}
    assert not bare.manifest_path("gait", GAITS[1].recipe).exists()


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def fifo(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


DAMAGE: dict[str, Callable[[Path], object]] = {
    "flipped": flip,
    "cut": lambda path: os.truncate(path, path.stat().st_size // 2),
    "huge": lambda path: os.truncate(path, 10**12),  # a hole: no space is needed for it
    "gone": lambda path: path.unlink(),
    "fifo": fifo,
}


def named(*names: str, size: int = 0) -> Callable[[Path], object]:
    """Let a manifest list files of such names."""
    table = {name: files.FileFacts(files.digest_text(""), size) for name in names}
    plain = {name: {"sha256": facts.sha256, "size": size} for name, facts in table.items()}
    result = {"object": files.digest_table(table), "files": plain, "summary": {}}
    return partial(forge, result=result)


def noted(**metadata: object) -> Callable[[Path], object]:
    """Change run metadata beside a manifest."""

    def note(path: Path) -> None:
        values = files.read_json(path)
        path.write_text(files.canonical(values | {"facts": values["facts"] | metadata}))

    return note


FORGED: dict[str, Callable[[Path], object]] = {
    **DAMAGE,
    "run metadata": noted(wall_s="long"),
    "a digit": lambda path: path.write_text(path.read_text().replace("1.5", "1.6")),
    "brackets": lambda path: path.write_text("[" * 100_000),
    "of another": partial(forge, recipe="0" * 64),
    "unchecked": partial(forge, input_objects={"a": []}),
    "outside": named("../../../escaped"),
    "absolute": named("/tmp/escaped"),
    "folder and file": named("a", "a/b"),
    "line feed": named("a\nb"),
    "long": named("x" * 300),
    "size": named("x", size=10**15),
}


@pytest.mark.parametrize(
    ("kind", "name"), [*(("result", name) for name in FORGED), *(("file", name) for name in DAMAGE)]
)
def test_what_a_remote_says_is_not_trusted(kind, name, filled, full, bare):
    path = filled.file(full, GAITS[0]) if kind == "file" else filled.result(GAITS[0])
    before = set(filled.folder.parent.rglob("*"))
    FORGED[name](path)
    account = pull(bare, JOBS, filled.remote)
    gone = kind == "result" and not path.exists()
    outcome = "not there" if gone else "damaged"
    assert account.counts == {outcome: 1, "taken": 5, "of other inputs": 2}
    start = f"gait 0 ({GAITS[0].recipe[:12]}): damaged in {filled.remote.url}: "
    assert [line.startswith(start) for line in account.damage] == [True] * (not gone)
    assert not any("\n" in line or len(line) > 1000 for line in account.damage)
    written = set(filled.folder.parent.rglob("*")) - before
    assert all(path.is_relative_to(bare.root) for path in written)
    assert not list((bare.root / "objects" / "tmp").iterdir())
    assert verify(bare) == Removed([], [])
    account = push(full, JOBS, filled.remote, verify=True)
    assert account.counts == {"sent": 1, "already there": 7}
    assert pull(bare, JOBS, filled.remote).counts == {"taken": 3}
    assert contents(bare) == contents(full)


def test_what_is_damaged_here_stays_here(place, full, bare):
    damage(data(full, full.read_manifest("gait", GAITS[0].recipe)))
    found = push(full, JOBS, place.remote)
    assert found.counts == {"damaged": 1, "sent": 7}
    (line,) = found.damage
    assert line.endswith("damaged here: run `slider store verify`")
    compute(bare, GAITS[0])
    push(bare, JOBS, place.remote)
    assert pull(full, JOBS, place.remote).counts == {"taken": 1}
    assert verify(full) == Removed([], [])


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
    assert verify(store) == Removed([], [])
    assert run() == 0
    pull(bare, JOBS, place.remote)
    assert contents(bare) == contents(full)


def test_the_command_says_what_travelled(place, full, bare, capsys):
    url = place.remote.url
    assert command(full, "push", url, "library") == 0
    assert capsys.readouterr().out.startswith(f"push to {url}: 7 sent (0.0 MB) in ")
    assert command(full, "push", url, "--all") == 0
    flip(place.file(full, TABLE))
    assert command(bare, "pull", url) == 1
    assert capsys.readouterr().err.startswith(f"table ({TABLE.recipe[:12]}): damaged in {url}: ")
    assert command(full, "push", url, "--verify") == 0
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
