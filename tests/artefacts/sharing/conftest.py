"""Remotes of every kind."""

from collections.abc import Iterator

import pytest

from slider.artefacts.sharing.remote import Remote
from tests.artefacts.sharing.servers import s3_server, ssh_server


@pytest.fixture(params=["folder", "url", "s3", "ssh"])
def anywhere(request, tmp_path) -> Iterator[Remote]:
    """Each kind of remote that can be written."""
    if request.param == "s3":
        with s3_server() as url:
            yield Remote(url)
    elif request.param == "ssh":
        with ssh_server(tmp_path / "home") as url:
            yield Remote(f"{url}{tmp_path}/remote")
    else:
        yield Remote(("file://" if request.param == "url" else "") + str(tmp_path / "remote"))
