"""Who may ask the emulated web camera: Basic, and Digest with nonces that grow old."""

from __future__ import annotations

import base64
import binascii
import hmac
import random
import threading

from cell.drivers.axis_vapix.authorization import digest_response, parse_parameters
from cell.twin.emulators.axis_vapix.settings import EmulatedAxisSettings

_REALM = "AXIS_00408C7C9A41"


class Gatekeeper:
    """Judges `Authorization` headers; threads may share it.

    Args:
        settings: The way of asking, the user and the password.
        seed: Seed of the nonces.
    """

    def __init__(self, settings: EmulatedAxisSettings, seed: int) -> None:
        self._settings = settings
        self._random = random.Random(seed)
        self._lock = threading.Lock()
        self._counts: dict[str, int] = {}

    def admits(self, header: str, method: str, uri: str) -> bool:
        """Return whether a request may pass."""
        mode = self._settings.auth
        scheme, _, rest = header.partition(" ")
        if mode == "none":
            return True
        if scheme.lower() == "basic" and mode in ("basic", "both"):
            return self._is_known(rest)
        if scheme.lower() == "digest" and mode in ("digest", "both"):
            return self._has_answered(parse_parameters(rest), method, uri)
        return False

    def challenges(self, header: str) -> list[str]:
        """Return the `WWW-Authenticate` headers of a refusal."""
        mode = self._settings.auth
        found = []
        if mode in ("digest", "both"):
            found.append(self._digest(self._is_old(header)))
        if mode in ("basic", "both"):
            found.append(f'Basic realm="{_REALM}"')
        return found

    def _is_known(self, pair: str) -> bool:
        try:
            told = base64.b64decode(pair, validate=True)
        except binascii.Error:
            return False
        expected = f"{self._settings.user}:{self._settings.password}".encode()
        return hmac.compare_digest(told, expected)

    def _has_answered(self, told: dict[str, str], method: str, uri: str) -> bool:
        expected = digest_response(
            algorithm="MD5",
            user=self._settings.user,
            realm=_REALM,
            password=self._settings.password,
            method=method,
            uri=uri,
            nonce=told.get("nonce", ""),
            quality="auth",
            count=told.get("nc", ""),
            client_nonce=told.get("cnonce", ""),
        )
        right = told.get("uri") == uri and told.get("username") == self._settings.user
        if not (right and hmac.compare_digest(told.get("response", ""), expected)):
            return False
        return self._counts_up(told.get("nonce", ""), told.get("nc", ""))

    def _counts_up(self, nonce: str, count: str) -> bool:
        """Return whether the nonce is ours, young, and its count never seen."""
        with self._lock:
            last = self._counts.get(nonce)
            try:
                number = int(count, 16)
            except ValueError:
                return False
            if last is None or number <= last or number > self._settings.nonce_uses:
                return False
            self._counts[nonce] = number
            return True

    def _is_old(self, header: str) -> bool:
        """Return whether a header was turned down only because its nonce is used up."""
        told = parse_parameters(header.partition(" ")[2])
        with self._lock:
            last = self._counts.get(told.get("nonce", ""), 0)
        return last >= self._settings.nonce_uses

    def _digest(self, is_old: bool) -> str:
        with self._lock:
            nonce = f"{self._random.getrandbits(128):032x}"
            self._counts[nonce] = 0
        stale = ", stale=true" if is_old else ""
        return f'Digest realm="{_REALM}", nonce="{nonce}", algorithm=MD5, qop="auth"{stale}'
