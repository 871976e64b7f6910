"""An emulator that a thread of its own works in real time, for programs that open its port.

The thread sleeps until bytes come, the emulator has something to say, or somebody wakes it
through a pipe; it never polls. A program talks to one device over one port, so the only
thing to be locked is what several devices share: the twin's world. Emulators of one world
are given one lock.

Within one process, and on a simulated clock, `stepped` needs no thread at all.
"""

from __future__ import annotations

import contextlib
import logging
import os
import select
import threading
from types import TracebackType
from typing import Self

from cell.clock import Clock
from cell.errors import CellError, LinkError
from cell.links.base import Tap
from cell.twin.serving.ends import DeviceEnd
from cell.twin.wire_faults import FaultyEmulator

_log = logging.getLogger(__name__)

_ANSWERED_S = 5.0
"""How long the thread may take to notice that it is wanted."""
_LEAST_WAIT_S = 0.0001


class EmulatorServer:
    """Works an emulator at the device's end of a port until it is stopped.

    Args:
        name: Name of the device, for traces.
        emulator: The device; a pulled cable makes its port vanish.
        end: The device's end of the port.
        clock: Real time.
        lock: Held while the emulator works; one for all emulators of one world.
        tap: Shown every byte that passes.
        byte_s: Time between two bytes of a reply, to pace it as the line would; replies leave
            whole without. A reply's last byte is then out later than in memory by the time
            the reply takes, because emulators count that time already.
    """

    def __init__(
        self,
        name: str,
        emulator: FaultyEmulator,
        end: DeviceEnd,
        clock: Clock,
        *,
        lock: threading.RLock | None = None,
        tap: Tap | None = None,
        byte_s: float = 0.0,
    ) -> None:
        self._name = name
        self._emulator = emulator
        self._end = end
        self._clock = clock
        self._lock = lock or threading.RLock()
        self._tap = tap
        self._byte_s = byte_s
        self._is_stopping = threading.Event()
        self._cable_done = threading.Event()
        self._wanted_plugged = True
        self._wake_r, self._wake_w = os.pipe()
        os.set_blocking(self._wake_r, False)
        self._thread = threading.Thread(target=self._run, name=f"emulator-{name}", daemon=True)
        emulator.on_cable(self._set_plugged)

    @property
    def name(self) -> str:
        """Name of the device."""
        return self._name

    @property
    def place(self) -> str:
        """What a program opens: a path, or host and port."""
        return self._end.place

    @property
    def is_running(self) -> bool:
        """Whether the thread is there."""
        return self._thread.is_alive()

    def start(self) -> None:
        """Begin to serve."""
        self._thread.start()

    def stop(self) -> None:
        """Stop serving and make the port vanish; stopping twice is harmless.

        Raises:
            CellError: The thread does not end.
        """
        if self._wake_w < 0:
            return
        self._is_stopping.set()
        self._wake()
        if self._thread.ident is not None:
            self._thread.join(_ANSWERED_S)
            if self._thread.is_alive():
                raise CellError(f"the emulator of {self._name} does not stop")
        self._end.unplug()
        os.close(self._wake_r)
        os.close(self._wake_w)
        self._wake_r = self._wake_w = -1

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    def _run(self) -> None:
        try:
            while not self._is_stopping.is_set():
                self._speak()
                self._await()
                self._listen()
        except CellError as error:
            _log.error("%s: the emulator has ended: %s", self._name, error)

    def _speak(self) -> None:
        data = b""
        with self._lock, contextlib.suppress(LinkError):
            data = self._emulator.transmit(self._clock.now_s())
        if not data:
            return
        if self._tap is not None:
            self._tap(self._name, "from_device", data)
        if not self._byte_s:
            self._end.say(data)
            return
        for index in range(len(data)):
            if self._is_stopping.wait(self._byte_s):
                return
            self._end.say(data[index : index + 1])

    def _await(self) -> None:
        """Sleep until there is something to do."""
        next_s = self._emulator.next_output_s()
        # An emulator that is due but says nothing must not make this spin; one that became
        # due since it was asked loses nothing that a person or a driver could tell.
        wait_s = None if next_s is None else max(next_s - self._clock.now_s(), _LEAST_WAIT_S)
        waited_on = [self._wake_r, *self._end.descriptors()]
        if self._wake_r in select.select(waited_on, [], [], wait_s)[0]:
            with contextlib.suppress(BlockingIOError):
                os.read(self._wake_r, 4096)
            self._follow_cable()

    def _listen(self) -> None:
        data = self._end.hear()
        if not data:
            return
        if self._tap is not None:
            self._tap(self._name, "to_device", data)
        with self._lock, contextlib.suppress(LinkError):
            self._emulator.receive(data, self._clock.now_s())

    def _follow_cable(self) -> None:
        if self._wanted_plugged:
            self._end.plug()
        else:
            self._end.unplug()
        self._cable_done.set()

    def _set_plugged(self, is_plugged: bool) -> None:
        """Have the thread pull or put in the cable, and wait until it has."""
        self._wanted_plugged = is_plugged
        if not self.is_running:
            self._follow_cable()
            return
        self._cable_done.clear()
        self._wake()
        if not self._cable_done.wait(_ANSWERED_S):
            raise CellError(f"the emulator of {self._name} does not follow its cable")

    def _wake(self) -> None:
        os.write(self._wake_w, b"!")
