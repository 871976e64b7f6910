"""A TCP link waits for bytes in both ways that systems have."""

from __future__ import annotations

import select
import socket

import pytest

from cell.links.errors import DeviceVanished
from cell.links.tcp import TcpLink
from cell.profile import TcpProfile


@pytest.mark.parametrize("is_polled", [True, False])
def test_bytes_and_an_end_are_noticed(is_polled: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if not is_polled:
        monkeypatch.delattr(select, "poll")  # As on Windows.
    with socket.create_server(("127.0.0.1", 0)) as listening:
        port = listening.getsockname()[1]
        profile = TcpProfile(host="127.0.0.1", port=port)
        link = TcpLink("arm", profile, is_polled=is_polled)
        device, _ = listening.accept()
    assert link.read(0.0) == b""
    device.sendall(b"QoK")
    assert link.read(5.0) == b"QoK"
    device.close()
    with pytest.raises(DeviceVanished):
        link.read(5.0)
    link.close()
