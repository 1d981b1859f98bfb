"""Real servers on this machine for remotes: S3, HTTP and ssh."""

import os
import socket
import threading
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import paramiko
import pytest
import s3fs
from moto.server import ThreadedMotoServer

from slider.artefacts.sharing.remote import Remote
from slider.artefacts.sharing.ssh import KnownHostFileSystem

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
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AWS_ENDPOINT_URL", f"http://{host}:{port}")
        patch.setenv("AWS_ACCESS_KEY_ID", "someone")
        patch.setenv("AWS_SECRET_ACCESS_KEY", "something")
        patch.setenv("AWS_DEFAULT_REGION", "us-east-1")
        patch.setenv("AWS_CONFIG_FILE", os.devnull)
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
    with _serving(partial(handler, directory=str(folder))) as url:
        yield url


@contextmanager
def endless_server() -> Iterator[str]:
    """A server that sends zeros until it is no longer heard."""
    with _serving(_Endless) as url:
        yield url


@contextmanager
def _serving(handler: Callable) -> Iterator[str]:
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


class _Silent(SimpleHTTPRequestHandler):
    missing = 404

    def send_error(self, code: int, *arguments) -> None:
        super().send_error(self.missing if code == 404 else code, *arguments)

    def log_message(self, *_) -> None:
        pass


class _Endless(_Silent):
    def do_GET(self) -> None:
        self.send_response(200)
        self.end_headers()
        with suppress(OSError):
            while True:
                self.wfile.write(bytes(2**16))


@contextmanager
def ssh_server(home: Path) -> Iterator[str]:
    """A server of the whole file system, which the settings of a home folder know by name."""
    key, host_key = paramiko.ECDSAKey.generate(), paramiko.ECDSAKey.generate()
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        folder = home / ".ssh"
        folder.mkdir(parents=True)
        key.write_private_key_file(str(folder / "id_work"))
        line = f"[127.0.0.1]:{port} {host_key.get_name()} {host_key.get_base64()}\n"
        (folder / "known_hosts").write_text(line)
        settings = (
            "HostName 127.0.0.1",
            f"Port {port}",
            "User me",
            f"IdentityFile {folder}/id_work",
        )
        (folder / "config").write_text("\n  ".join([f"Host {HOST}", *settings]) + "\n")
        threading.Thread(target=_serve, args=(listener, host_key, key), daemon=True).start()
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("HOME", str(home))
            patch.delenv("SSH_AUTH_SOCK", raising=False)
            KnownHostFileSystem.clear_instance_cache()
            yield f"sftp://{HOST}"


def _serve(listener: socket.socket, host_key: paramiko.PKey, key: paramiko.PKey) -> None:
    while True:
        try:
            connection, _ = listener.accept()
        except OSError:  # closed
            return
        transport = paramiko.Transport(connection)
        transport.add_server_key(host_key)
        transport.set_subsystem_handler("sftp", paramiko.SFTPServer, _Files)
        transport.start_server(server=_Door(key))


class _Door(paramiko.ServerInterface):
    """Lets in who has the key."""

    def __init__(self, key: paramiko.PKey) -> None:
        self.key = key

    def check_auth_publickey(self, username: str, key: paramiko.PKey) -> int:
        known = (username, key.get_base64()) == ("me", self.key.get_base64())
        return paramiko.AUTH_SUCCESSFUL if known else paramiko.AUTH_FAILED

    def check_channel_request(self, kind: str, chanid: int) -> int:
        return paramiko.OPEN_SUCCEEDED


class _Files(paramiko.SFTPServerInterface):
    """The file system of this machine."""

    def stat(self, path: str):
        return _answer(lambda: paramiko.SFTPAttributes.from_stat(os.stat(path)))

    lstat = stat

    def open(self, path: str, flags: int, attr):
        return _answer(lambda: _Handle(path, flags))

    def mkdir(self, path: str, attr):
        return _answer(lambda: os.mkdir(path) or paramiko.SFTP_OK)

    def remove(self, path: str):
        return _answer(lambda: os.remove(path) or paramiko.SFTP_OK)

    def posix_rename(self, oldpath: str, newpath: str):
        return _answer(lambda: os.replace(oldpath, newpath) or paramiko.SFTP_OK)


class _Handle(paramiko.SFTPHandle):
    def __init__(self, path: str, flags: int) -> None:
        super().__init__(flags)
        mode = "wb" if flags & (os.O_WRONLY | os.O_RDWR) else "rb"
        self.readfile = self.writefile = open(path, mode)  # noqa: SIM115

    def stat(self):
        return paramiko.SFTPAttributes.from_stat(os.fstat(self.readfile.fileno()))


def _answer(work):
    try:
        return work()
    except OSError as error:
        return paramiko.SFTPServer.convert_errno(error.errno)
