"""What is said of remotes that do not work, in one line."""

import errno
import os

import fsspec
import pytest

from slider.artefacts.remote import MARKER, Remote
from slider.core.errors import UserError
from tests.artefacts.servers import http_server, s3_server, ssh_server

FILES = fsspec.get_filesystem_class("file")


def test_a_bucket_or_server_that_is_not_there(monkeypatch):
    with s3_server():
        remote = Remote("s3://nothing/slider")
        assert remote.open() is False
        with pytest.raises(UserError, match=r"^remote s3://nothing/slider: .*does not exist"):
            remote.open(create=True)
        monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:1")
        fsspec.get_filesystem_class("s3").clear_instance_cache()
        with pytest.raises(UserError, match=r"^remote s3://group/slider: [^\n]+$"):
            Remote("s3://group/slider").open()


def test_unknown_hosts_and_users_are_refused(tmp_path):
    with ssh_server(tmp_path / "home") as url:
        config, hosts = (tmp_path / "home" / ".ssh" / name for name in ("config", "known_hosts"))
        known, settings = hosts.read_text(), config.read_text()
        hosts.write_text("")
        for address in (url, url.replace("sftp://", "ssh://")):
            with pytest.raises(UserError, match="Host key is not trusted for host 127"):
                Remote(f"{address}{tmp_path}/remote").open()
        hosts.write_text(known)
        config.write_text(settings.replace("IdentityFile", "# IdentityFile"))
        with pytest.raises(UserError, match=r"^remote sftp://cluster/[^\n]+$"):
            Remote(f"{url}{tmp_path}/remote").open()


@pytest.mark.parametrize("address", ["http://[::1", "http://[::1]:port/x", "quatsch://x"])
def test_an_address_that_is_none_is_one_line(address):
    with pytest.raises(UserError, match=r"^[^\n]+$"):
        Remote(address).open()


@pytest.mark.parametrize("content", ["[]", '{"layout":1}'])
def test_a_store_of_another_layout(content, tmp_path):
    (tmp_path / MARKER).write_text(content)
    with pytest.raises(UserError, match="expected a store of layout 3, found another"):
        Remote(str(tmp_path)).open()


def test_missing_packages_and_full_disks_have_a_name(tmp_path, monkeypatch):
    remote = Remote(str(tmp_path / "remote"))
    remote.open(create=True)
    packages = r"Install sshfs; .* pip install -e '\.\[remote\]' -c constraints\.txt$"
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), f"{tmp_path}/y")
    for method, error, message, attempt in (
        ("get_file", full, f"No space left .*{tmp_path}/y", lambda: remote.get({tmp_path: MARKER})),
        ("pipe_file", full, "remote: .*No space left", lambda: remote.write("x", b"x")),
        ("info", ImportError("Install sshfs"), packages, lambda: remote.size("x")),
    ):

        def fail(*_, error=error, **__):
            raise error

        with monkeypatch.context() as patch:
            patch.setattr(FILES, method, fail)
            with pytest.raises(UserError, match=message):
                attempt()


def test_what_may_not_be_listed_answers_forbidden(tmp_path):
    """A public bucket does so for what it lacks."""
    with http_server(tmp_path, missing=403) as url:
        remote = Remote(url)
        assert remote.open() is False
        (tmp_path / MARKER).write_text('{"layout":3}')
        assert remote.open() is True
        assert remote.read("results/x") is None
