"""What is said of remotes that do not work, in one line and in time."""

import errno
import json
import os
import re
import shlex
import socket
import sys
import time
from pathlib import Path

import fsspec
import pytest
from fsspec.registry import _registry

from slider.artefacts.sharing.archive import DamageError
from slider.artefacts.sharing.remote import MARKER, Remote
from slider.core.errors import UserError
from tests.artefacts.sharing.servers import endless_server, http_server, s3_server, ssh_server


def test_a_bucket_that_is_not_there():
    with s3_server():
        remote = Remote("s3://nothing/slider")
        assert remote.open() is False
        with pytest.raises(
            UserError, match=r"^remote s3://nothing/slider: .*bucket does not exist"
        ):
            remote.create()


def test_a_server_that_is_switched_off(monkeypatch):
    with s3_server():
        monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:1")
        fsspec.get_filesystem_class("s3").clear_instance_cache()
        with pytest.raises(UserError, match=r"^remote s3://group/slider: [^\n]+$"):
            Remote("s3://group/slider").open()


def test_a_server_that_never_answers():
    with socket.create_server(("127.0.0.1", 0)) as server:
        started = time.monotonic()
        url = f"http://127.0.0.1:{server.getsockname()[1]}/x"
        with pytest.raises(UserError, match=rf"^remote {url}: no answer within 0.5 s$"):
            Remote(url, contact_s=0.5).open()
        assert time.monotonic() - started < 5


def test_a_host_that_nobody_knows_is_refused(tmp_path):
    with ssh_server(tmp_path / "home") as url:
        (tmp_path / "home" / ".ssh" / "known_hosts").write_text("")
        with pytest.raises(UserError, match="not found in known_hosts"):
            Remote(f"{url}{tmp_path}/remote").open()


PROXY = """import os, socket, sys, threading
from pathlib import Path

Path({log!r}).write_text(" ".join(sys.argv[1:]))
there = socket.create_connection(("127.0.0.1", {port}))
def answer():
    while content := there.recv(65536):
        os.write(1, content)
threading.Thread(target=answer, daemon=True).start()
while content := os.read(0, 65536):
    there.sendall(content)
"""


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("ProxyCommand ssh gate nc %h %p", "gate nc 127.0.0.1 PORT"),
        ("ProxyJump gate", "-o BatchMode=yes -W [127.0.0.1]:PORT ssh://gate"),
        ("ProxyJump a,me@b:7", "-o BatchMode=yes -J a -W [127.0.0.1]:PORT ssh://me@b:7"),
    ],
)
def test_a_host_behind_another(line, expected, tmp_path, monkeypatch):
    with ssh_server(tmp_path / "home") as url:
        config = tmp_path / "home" / ".ssh" / "config"
        port = re.findall(r"Port (\d+)", config.read_text())[0]
        config.write_text(f"{config.read_text()}  {line}\n")
        program, log = tmp_path / "ssh", str(tmp_path / "log")
        (tmp_path / "proxy.py").write_text(PROXY.format(log=log, port=port))
        words = shlex.join([sys.executable, str(tmp_path / "proxy.py")])
        program.write_text(f'#!/bin/sh\nexec {words} "$@"\n')
        program.chmod(0o755)
        monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
        remote = Remote(f"{url}{tmp_path}/remote")
        remote.create()
        remote.write("results/x", bytes(100_000))
        assert remote.read("results/x") == bytes(100_000)
        assert Path(log).read_text() == expected.replace("PORT", port)


def test_a_key_that_the_host_does_not_know(tmp_path):
    with ssh_server(tmp_path / "home") as url:
        config = tmp_path / "home" / ".ssh" / "config"
        config.write_text(config.read_text().replace("User me", "User another"))
        with pytest.raises(UserError, match=r"^remote sftp://cluster/[^\n]+$"):
            Remote(f"{url}{tmp_path}/remote").open()


@pytest.mark.parametrize("content", [b"", b"[]", b'{"layout": 2}', b"\xff", b"3"])
def test_a_store_of_another_layout(content, tmp_path):
    (tmp_path / MARKER).write_bytes(content)
    with pytest.raises(UserError, match="expected a store of layout 1, found another"):
        Remote(str(tmp_path)).open()


def test_missing_packages_have_a_name(monkeypatch):
    monkeypatch.setitem(sys.modules, "paramiko", None)
    monkeypatch.delitem(sys.modules, "slider.artefacts.sharing.ssh", raising=False)
    monkeypatch.delitem(sys.modules, "fsspec.implementations.sftp", raising=False)
    monkeypatch.delitem(_registry, "sftp", raising=False)
    text = r"needs packages: pip install -e '\.\[remote\]' -c constraints\.txt$"
    with pytest.raises(UserError, match=text):
        Remote("sftp://host/x").open()


def test_a_folder_that_may_not_be_written(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(fsspec.get_filesystem_class("file"), "mkdir", refuse)
    with pytest.raises(UserError, match=r"remote: Permission denied$"):
        Remote(str(tmp_path / "remote")).create()


def test_a_full_disk_here_is_not_that_of_the_remote(tmp_path, monkeypatch):
    def fill(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    (tmp_path / "x").write_bytes(b"x")
    monkeypatch.setattr(fsspec.get_filesystem_class("file"), "get_file", fill)
    with pytest.raises(UserError, match=rf"^expected to write {tmp_path}/y, found: No space"):
        Remote(str(tmp_path)).fetch("x", tmp_path / "y", 1)


def test_a_failed_write_leaves_no_trace(tmp_path, monkeypatch):
    remote = Remote(str(tmp_path / "remote"))
    remote.create()
    monkeypatch.setattr(fsspec.get_filesystem_class("file"), "mv", lambda *_: 1 / 0)
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(UserError, match="division by zero"):
        remote.write("results/x", b"x")
    assert sorted(tmp_path.rglob("*")) == before


def test_what_may_not_be_listed_answers_forbidden(tmp_path):
    """A public bucket does so for what it lacks."""
    with http_server(tmp_path, missing=403) as url:
        remote = Remote(url)
        assert remote.open() is False
        Path(tmp_path / MARKER).write_text(json.dumps({"layout": 1}))
        assert remote.open() is True
        assert remote.read("results/x") is None
        assert remote.fetch("archives/x", tmp_path / "x", 1) is False


def test_a_right_that_is_lost_on_the_way_is_no_absence(tmp_path):
    """Else a push would replace what it may not read, and a pull have it computed again."""
    with http_server(tmp_path, missing=403) as url, pytest.raises(UserError, match=": 403, "):
        Remote(url).read("results/x")


@pytest.mark.parametrize("name", [MARKER, "results/x"])
def test_what_may_not_be_read_in_a_folder_is_no_absence(name, tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    remote = Remote(str(tmp_path / "remote"))
    remote.create()
    monkeypatch.setattr(fsspec.get_filesystem_class("file"), "cat_file", refuse)
    with pytest.raises(UserError, match=r"remote: Permission denied$"):
        remote.read(name)


def test_an_answer_without_an_end_ends(tmp_path):
    with endless_server() as url, pytest.raises(DamageError, match="expected 10 bytes, found more"):
        Remote(url).fetch("archives/x", tmp_path / "x", 10)


@pytest.mark.parametrize("size", [10, 9])
def test_no_more_than_what_is_expected_is_copied(size, anywhere, tmp_path):
    anywhere.create()
    anywhere.write("archives/x", bytes(10))
    if size == 10:
        assert anywhere.fetch("archives/x", tmp_path / "x", size)
        assert (tmp_path / "x").read_bytes() == bytes(10)
    else:
        with pytest.raises(DamageError, match="expected 9 bytes, found more"):
            anywhere.fetch("archives/x", tmp_path / "x", size)
