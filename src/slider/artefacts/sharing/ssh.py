"""Files over ssh, as fsspec has them, from known hosts only and with the user's ssh settings."""

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import paramiko
from fsspec.implementations.sftp import SFTPFileSystem

CONNECTION_S = 10.0
ANSWER_S = 60.0
_SETTINGS = Path(".ssh") / "config"

logging.getLogger("paramiko").addHandler(logging.NullHandler())  # it raises what it logs


class KnownHostFileSystem(SFTPFileSystem):
    """Refuses a host that ``~/.ssh/known_hosts`` lacks; fsspec's own accepts any.

    Of ``~/.ssh/config`` it honours ``HostName``, ``User``, ``Port``, ``IdentityFile``,
    ``ProxyCommand`` and ``ProxyJump``; the last runs the program ``ssh``.
    """

    def _connect(self) -> None:
        waits = ("timeout", "banner_timeout", "auth_timeout")
        settings: dict[str, Any] = dict.fromkeys(waits, CONNECTION_S)
        host, arguments = _look_up(self.host)
        self.client = paramiko.SSHClient()
        self.client.load_system_host_keys()
        self.client.set_missing_host_key_policy(paramiko.RejectPolicy())
        self.client.connect(host, **(settings | arguments | self.ssh_kwargs))
        self.ftp = self.client.open_sftp()
        channel = self.ftp.get_channel()
        if channel is not None:
            channel.settimeout(ANSWER_S)


def _look_up(host: str) -> tuple[str, dict[str, Any]]:
    """Read host name and arguments of the connection to a host from ``~/.ssh/config``."""
    path = Path.home() / _SETTINGS
    if not path.is_file():
        return host, {}
    options = paramiko.SSHConfig.from_path(str(path)).lookup(host)
    arguments: dict[str, Any] = {"username": options["user"]} if "user" in options else {}
    if "port" in options:
        arguments["port"] = int(options["port"])
    if "identityfile" in options:
        arguments["key_filename"] = options["identityfile"]
    name = options.get("hostname", host)
    command = options.get("proxycommand") or _jump(options, f"[{name}]:{options.get('port', 22)}")
    if command:
        arguments["sock"] = paramiko.ProxyCommand(command)
    return name, arguments


def _jump(options: Mapping[str, Any], target: str) -> str | None:
    """Command that connects to a target over the hosts of ``ProxyJump``."""
    jumps = options.get("proxyjump", "none")
    if jumps == "none":
        return None
    first, _, last = jumps.rpartition(",")
    before = f"-J {first} " if first else ""
    return f"ssh -o BatchMode=yes {before}-W {target} ssh://{last.removeprefix('ssh://')}"
