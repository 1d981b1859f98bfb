"""What a hostile remote could do is refused: in one line, in time, with nothing written outside."""

import os
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from slider.artefacts.maintenance import verify
from slider.artefacts.remote import MARKER, DamageError, Remote
from slider.artefacts.transfer import pull, push
from slider.core import files
from slider.core.errors import UserError
from tests.artefacts.samples import GAITS, JOBS, contents, forge


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
    table = {name: files.FileEntry(files.digest_text(""), size) for name in names}
    plain = {name: {"sha256": entry.sha256, "size": size} for name, entry in table.items()}
    result = {"object": files.digest_table(table), "files": plain, "summary": {}}
    return partial(forge, result=result)


def noted(**metadata: object) -> Callable[[Path], object]:
    """Change run metadata beside a manifest."""

    def note(path: Path) -> None:
        values = files.read_json(path)
        path.write_text(
            files.canonical(values | {"run_metadata": values["run_metadata"] | metadata})
        )

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
    report = pull(bare, JOBS, filled.remote)
    gone = kind == "result" and not path.exists()
    outcome = "missing in the remote" if gone else "damaged"
    assert report.counts == {outcome: 1, "fetched": 5, "waiting for inputs": 2}
    start = f"gait 0 ({GAITS[0].recipe[:12]}): damaged in {filled.remote.url}: "
    assert [line.startswith(start) for line in report.damage] == [True] * (not gone)
    assert not any("\n" in line or len(line) > 1000 for line in report.damage)
    written = set(filled.folder.parent.rglob("*")) - before
    assert all(path.is_relative_to(bare.root) for path in written)
    assert not list((bare.root / "objects" / "tmp").iterdir())
    assert verify(bare) == []
    report = push(full, JOBS, filled.remote, force=True)
    assert report.counts == {"uploaded": 8}
    assert pull(bare, JOBS, filled.remote).counts == {"fetched": 3}
    assert contents(bare) == contents(full)


def test_a_folder_is_no_file(tmp_path):
    (tmp_path / "folder").mkdir()
    with pytest.raises(DamageError, match="expected a file, found another kind: "):
        Remote(str(tmp_path)).read("folder", 10)


@pytest.mark.parametrize("content", [b"[]", b'{"layout": 1}', bytes(10_000)])
def test_a_store_of_another_layout(content, tmp_path):
    (tmp_path / MARKER).write_bytes(content)
    with pytest.raises(UserError, match="expected a store of layout 3, found another"):
        Remote(str(tmp_path)).open()


def test_a_server_that_never_answers():
    with socket.create_server(("127.0.0.1", 0)) as server:
        started = time.monotonic()
        url = f"http://127.0.0.1:{server.getsockname()[1]}/x"
        with pytest.raises(UserError, match=rf"^remote {url}: no answer within 0.5 s$"):
            Remote(url, contact_s=0.5).open()
        assert time.monotonic() - started < 5


class _Endless(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        self.send_response(200)
        self.end_headers()
        with suppress(OSError):  # the reader has hung up
            while True:
                self.wfile.write(bytes(2**16))

    def log_message(self, *_) -> None:
        pass


def test_an_endless_answer_ends_at_the_limit(tmp_path):
    with ThreadingHTTPServer(("127.0.0.1", 0), _Endless) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        remote = Remote(f"http://127.0.0.1:{server.server_port}")
        with pytest.raises(DamageError, match=r"expected \d+ bytes, found more"):
            remote.get({tmp_path / name: name for name in "ab"}, 1000)
        with pytest.raises(UserError, match="expected a store of layout 3, found another"):
            remote.open()
        server.shutdown()
    assert sum(path.stat().st_size for path in tmp_path.iterdir()) < 2**24
