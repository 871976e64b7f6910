"""A link that is opened when first used, and again after it was lost."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable

from cell.clock import Clock
from cell.errors import LinkError
from cell.links.base import Link
from cell.links.errors import NotOpened
from cell.stop import StopToken

_log = logging.getLogger(__name__)


class ReconnectingLink:
    """Survives that a cable is pulled and put back.

    An operation that finds the link broken fails once, with the LinkError; whether to
    repeat it is the driver's business, for only the driver knows what was sent and whether
    sending it twice does harm. The next operation opens the link anew: once at once, then
    after 0.1 s, 0.2 s, 0.4 s and so on, no more than `patience_s` in all for one loss. When
    that is used up, and before the link was ever open, an operation tries once and fails at
    once, so that a cell without a device is not a slow cell; the error then says that it lasts,
    and drivers do not repeat what they asked. What lay in the old link is
    gone with it.

    Args:
        name: Name of the device behind the link, as in the profile.
        open_link: Opens the link; raises LinkError where it cannot.
        clock: Waited on between two tries.
        token: Where a stop is asked for, nothing is waited for: the one try must do.
        first_wait_s: The first wait; each further one is twice as long.
        longest_wait_s: No wait is longer.
        patience_s: The waits for one loss are no longer than this together.
    """

    def __init__(
        self,
        name: str,
        open_link: Callable[[], Link],
        clock: Clock,
        *,
        token: StopToken | None = None,
        first_wait_s: float = 0.1,
        longest_wait_s: float = 2.0,
        patience_s: float = 5.0,
    ) -> None:
        self._name = name
        self._open_link = open_link
        self._clock = clock
        self._token = token
        self._first_wait_s = first_wait_s
        self._longest_wait_s = longest_wait_s
        self._patience_s = patience_s
        self._link: Link | None = None
        self._left_s = 0.0
        self._is_open = True
        self._was_lost = False
        self._reopened = 0

    @property
    def name(self) -> str:
        """Name of the device behind the link."""
        return self._name

    @property
    def reopened(self) -> int:
        """How often the link was opened again after a loss."""
        return self._reopened

    @property
    def is_connected(self) -> bool:
        """Whether the link was open when it was last used."""
        return self._link is not None

    def write(self, data: bytes) -> None:
        """Send all bytes, opening the link before if need be.

        Raises:
            LinkError: The link broke, or cannot be opened.
        """
        link = self._link or self._connect()
        try:
            link.write(data)
        except LinkError:
            self._lose()
            raise

    def read(self, timeout_s: float) -> bytes:
        """Return what has arrived, opening the link before if need be.

        Raises:
            LinkError: The link broke, or cannot be opened.
        """
        link = self._link or self._connect()
        try:
            return link.read(timeout_s)
        except LinkError:
            self._lose()
            raise

    def close(self) -> None:
        """Let the link go for good; closing twice is harmless."""
        self._is_open = False
        if self._link is not None:
            self._link.close()
            self._link = None

    def _connect(self) -> Link:
        if not self._is_open:
            raise LinkError(f"the link to {self._name} is closed")
        wait_s = self._first_wait_s
        while True:
            try:
                link = self._open_link()
                break
            except LinkError as error:
                wait_s = min(wait_s, self._left_s)
                if isinstance(error, NotOpened):
                    error.is_lasting = wait_s <= 0
                if wait_s <= 0 or (self._token is not None and self._token.is_set):
                    raise
            self._clock.sleep(wait_s)
            self._left_s -= wait_s
            wait_s = min(2.0 * wait_s, self._longest_wait_s)
        if self._was_lost:
            self._was_lost = False
            self._reopened += 1
            _log.warning("%s: the link is open again", self._name)
        self._link = link
        return link

    def _lose(self) -> None:
        """Let a broken link go; its closing may fail as its use did."""
        if self._link is not None:
            with contextlib.suppress(LinkError, OSError):
                self._link.close()
        self._link = None
        self._was_lost = True
        self._left_s = self._patience_s
