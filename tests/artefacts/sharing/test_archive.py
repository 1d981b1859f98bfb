"""Archives of objects: the same bytes for the same content, and nothing but that comes out."""

import io
import os
import tarfile
from collections.abc import Callable
from pathlib import Path

import pytest

from slider.artefacts.sharing.archive import DamageError, pack, packed_size, unpack
from slider.core import files

CONTENTS = {
    "empty": b"",
    "block": b"x" * 512,
    "deep/däta.bin": bytes(range(256)) * 5,
    f"{'long/' * 30}{'name' * 40}": b"far down",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, content in CONTENTS.items():
        path = tmp_path / "object" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return tmp_path / "object"


def test_what_comes_out_is_what_went_in(folder, tmp_path):
    table, archive, found = files.file_table(folder), tmp_path / "archive", tmp_path / "found"
    pack(folder, table, archive)
    assert archive.stat().st_size == packed_size(table)
    found.mkdir()
    unpack(archive, table, found)
    assert {name: (found / name).read_bytes() for name in files.list_files(found)} == CONTENTS


def test_the_bytes_depend_on_the_content_alone(folder, tmp_path):
    table = files.file_table(folder)
    pack(folder, table, tmp_path / "first")
    for name in CONTENTS:
        os.utime(folder / name, (1, 1))
        (folder / name).chmod(0o600)
    pack(folder, dict(reversed(table.items())), tmp_path / "second")
    assert (tmp_path / "first").read_bytes() == (tmp_path / "second").read_bytes()


def test_every_flipped_bit_of_content_is_found(tmp_path):
    (tmp_path / "object").mkdir()
    (tmp_path / "object" / "data").write_bytes(b"some data")
    table = files.file_table(tmp_path / "object")
    pack(tmp_path / "object", table, tmp_path / "archive")
    whole = (tmp_path / "archive").read_bytes()
    for place in range(512, 512 + 9):
        broken = bytearray(whole)
        broken[place] ^= 1
        (tmp_path / "archive").write_bytes(broken)
        (tmp_path / f"found{place}").mkdir()
        with pytest.raises(DamageError):
            unpack(tmp_path / "archive", table, tmp_path / f"found{place}")


def member(name: str, content: bytes = b"data", **values) -> tuple[tarfile.TarInfo, bytes]:
    info = tarfile.TarInfo(name)
    info.size = len(content)
    for key, value in values.items():
        setattr(info, key, value)
    return info, content


HOSTILE = {
    "outside": [member("../data")],
    "absolute": [member("/data")],
    "another": [member("other")],
    "twice": [member("data"), member("data")],
    "link": [member("data", b"", type=tarfile.SYMTYPE, linkname="/etc/passwd")],
    "hard link": [member("data", b"", type=tarfile.LNKTYPE, linkname="data")],
    "device": [member("data", b"", type=tarfile.CHRTYPE)],
    "folder": [member("data", b"", type=tarfile.DIRTYPE)],
    "shorter": [member("data", b"dat")],
    "another content": [member("data", b"tada")],
    "nothing": [],
}


@pytest.mark.parametrize("members", HOSTILE.values(), ids=list(HOSTILE))
def test_an_archive_writes_nothing_but_what_the_table_lists(members, tmp_path):
    (tmp_path / "object").mkdir()
    (tmp_path / "object" / "data").write_bytes(b"data")
    table = files.file_table(tmp_path / "object")
    with tarfile.open(tmp_path / "archive", "w") as archive:
        for info, content in members:
            archive.addfile(info, io.BytesIO(content))
    (tmp_path / "found").mkdir()
    with pytest.raises(DamageError):
        unpack(tmp_path / "archive", table, tmp_path / "found")
    assert {path.name for path in tmp_path.iterdir()} == {"object", "archive", "found"}
    assert not any(path.is_symlink() for path in (tmp_path / "found").iterdir())


@pytest.mark.parametrize(
    "names", [["../x"], ["/x"], ["a/../x"], ["./x"], ["a//x"], [""], ["."], ["a", "a/x"], ["x\0"]]
)
def test_a_table_names_plain_files_below_its_folder(names, tmp_path):
    table = {name: {"sha256": files.digest_text(""), "size": 0} for name in names}
    with tarfile.open(tmp_path / "archive", "w") as archive:
        for name in names:
            archive.addfile(tarfile.TarInfo(name))
    (tmp_path / "found").mkdir()
    with pytest.raises(DamageError):
        unpack(tmp_path / "archive", table, tmp_path / "found")
    assert files.list_files(tmp_path) == ["archive"]


CHANGES: dict[str, Callable[[bytes], bytes]] = {
    "truncated": lambda content: content[:-512],
    "longer": lambda content: content + b"x",
    "garbage": lambda content: b"\xff" * len(content),
    "zeros": lambda content: bytes(len(content)),
    "empty": lambda content: b"",
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=list(CHANGES))
def test_a_damaged_archive_is_one_line(change, folder, tmp_path):
    table, archive = files.file_table(folder), tmp_path / "archive"
    pack(folder, table, archive)
    archive.write_bytes(change(archive.read_bytes()))
    (tmp_path / "found").mkdir()
    with pytest.raises(DamageError, match=r"^expected .*, found [^\n]*$"):
        unpack(archive, table, tmp_path / "found")
