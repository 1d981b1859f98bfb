"""Real servers on this machine for remotes: S3, HTTP and ssh."""

import os
import threading
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import asyncssh
import pytest
import s3fs
from fsspec.asyn import get_loop, sync
from moto.server import ThreadedMotoServer
from sshfs import SSHFileSystem

from slider.artefacts.remote import Remote

HOST = "cluster"
"""Name of the ssh server in the user's settings."""
KINDS = ("folder", "url", "s3", "ssh")
"""Kinds of remote that can be written."""


@contextmanager
def anywhere(kind: str, folder: Path) -> Iterator[Remote]:
    """A remote of a kind, with what it needs below a folder."""
    if kind == "s3":
        with s3_server() as url:
            yield Remote(url)
    elif kind == "ssh":
        with ssh_server(folder / "home") as url:
            yield Remote(f"{url}{folder}/remote")
    else:
        yield Remote(("file://" if kind == "url" else "") + str(folder / "remote"))


@contextmanager
def s3_server() -> Iterator[str]:
    """A prefix in a server's bucket; the environment names the server, as it would a real one."""
    server = ThreadedMotoServer("127.0.0.1", 0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    settings = {"ENDPOINT_URL": f"http://{host}:{port}", "DEFAULT_REGION": "us-east-1"}
    settings |= {"ACCESS_KEY_ID": "a", "SECRET_ACCESS_KEY": "b", "CONFIG_FILE": os.devnull}
    with pytest.MonkeyPatch.context() as patch:
        for name, value in settings.items():
            patch.setenv(f"AWS_{name}", value)
        s3fs.S3FileSystem.clear_instance_cache()
        bucket = uuid.uuid4().hex  # servers of one process share what they hold
        s3fs.S3FileSystem().mkdir(bucket)
        yield f"s3://{bucket}/slider"
        s3fs.S3FileSystem.clear_instance_cache()
    server.stop()


@contextmanager
def http_server(folder: Path, missing: int = 404) -> Iterator[str]:
    """A server of a folder's files, with a status for those that are not there."""
    handler = type("Handler", (_Silent,), {"missing": missing})
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(handler, directory=str(folder))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


class _Silent(SimpleHTTPRequestHandler):
    missing = 404

    def send_error(self, code: int, *arguments) -> None:
        super().send_error(self.missing if code == 404 else code, *arguments)

    def log_message(self, *_) -> None:
        pass


@contextmanager
def ssh_server(home: Path) -> Iterator[str]:
    """A server of the whole file system, which the settings of a home folder know by name."""
    key, host_key = (asyncssh.generate_private_key("ssh-ed25519") for _ in range(2))
    folder = home / ".ssh"
    folder.mkdir(parents=True)
    key.write_private_key(folder / "id_work")
    key.write_public_key(folder / "id_work.pub")
    listen = partial(
        asyncssh.listen,
        "127.0.0.1",
        0,
        server_host_keys=[host_key],
        authorized_client_keys=str(folder / "id_work.pub"),
        sftp_factory=True,
    )
    loop = get_loop()  # of fsspec, in a thread of its own
    listener = sync(loop, listen)
    public = host_key.export_public_key("openssh").decode()
    (folder / "known_hosts").write_text(f"[127.0.0.1]:{listener.get_port()} {public}")
    (folder / "config").write_text(
        f"Host {HOST}\n HostName 127.0.0.1\n Port {listener.get_port()}\n"
        f" User me\n IdentityFile {folder}/id_work\n"
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HOME", str(home))
        patch.delenv("SSH_AUTH_SOCK", raising=False)
        SSHFileSystem.clear_instance_cache()
        yield f"sftp://{HOST}"
    listener.close()
