"""What is said of remotes that do not work, in one line and in time."""

import errno
import os
from unittest.mock import Mock

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


def test_missing_packages_have_a_name(monkeypatch):
    missing = Mock(side_effect=ImportError("Install sshfs"))  # as fsspec says it
    monkeypatch.setattr(fsspec, "url_to_fs", missing)
    text = r"needs packages: pip install -e '\.\[remote\]' -c constraints\.txt$"
    with pytest.raises(UserError, match=text):
        Remote("sftp://host/x").open()


@pytest.mark.parametrize("address", ["http://[::1", "http://[::1]:port/x", "quatsch://x"])
def test_an_address_that_is_none_is_one_line(address):
    with pytest.raises(UserError, match=r"^[^\n]+$"):
        Remote(address).open()


def test_rights_and_full_disks_have_their_place(tmp_path, monkeypatch):
    remote, new = Remote(str(tmp_path / "remote")), Remote(str(tmp_path / "new"))
    remote.open(create=True)
    before = sorted((tmp_path / "remote").rglob("*"))
    here = f"^expected to write {tmp_path}/y, found: No space"
    for method, number, message, attempt in (
        ("mkdir", errno.EACCES, r"new: Permission denied$", lambda: new.open(create=True)),
        # No absence, else a push would replace it.
        ("info", errno.EACCES, r"remote: Permission denied$", lambda: remote.read(MARKER, 100)),
        ("get_file", errno.ENOSPC, here, lambda: remote.get({tmp_path / "y": MARKER}, 100)),
        ("mv", errno.ENOSPC, "remote: No space left", lambda: remote.write("x", "x")),
    ):

        def fail(*_, number=number, **__):
            raise OSError(number, os.strerror(number))

        with monkeypatch.context() as patch:
            patch.setattr(FILES, method, fail)
            with pytest.raises(UserError, match=message):
                attempt()
    assert sorted((tmp_path / "remote").rglob("*")) == before


def test_what_may_not_be_listed_answers_forbidden(tmp_path):
    """A public bucket does so for what it lacks; a right that is lost on the way is no absence."""
    with http_server(tmp_path, missing=403) as url:
        remote = Remote(url)
        assert remote.open() is False
        with pytest.raises(UserError, match=": 403, "):
            remote.read("results/x", 10)
        (tmp_path / MARKER).write_text('{"layout": 3}')
        assert remote.open() is True
        assert remote.read("results/x", 10) is None
