"""HTTP Basic and Digest (RFC 7617, RFC 7616), without I/O."""

from __future__ import annotations

import base64
import hashlib
import re
import secrets
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

_CHALLENGE = re.compile(r"(?:^|,)\s*(Basic|Digest)\b", re.IGNORECASE)
_PARAMETER = re.compile(r'([\w-]+)\s*=\s*(?:"((?:[^"\\]|\\.)*)"|([^\s,]+))')
_HASHES = {"MD5": hashlib.md5, "SHA-256": hashlib.sha256}


@dataclass(frozen=True, slots=True)
class Challenge:
    """One way in which a server lets itself be convinced.

    Attributes:
        scheme: `basic` or `digest`.
        parameters: What it told, names in small letters.
    """

    scheme: str
    parameters: dict[str, str] = field(default_factory=dict)

    @property
    def algorithm(self) -> str:
        """Name of the hash of a digest; MD5 if none is told."""
        return self.parameters.get("algorithm", "MD5").upper()

    @property
    def is_usable(self) -> bool:
        """Whether it can be answered: an own hash, and a quality of none or `auth`."""
        if self.scheme == "basic":
            return True
        qualities = [one.strip() for one in self.parameters.get("qop", "auth").split(",")]
        return "nonce" in self.parameters and self.algorithm in _HASHES and "auth" in qualities


def parse_challenges(values: Sequence[str]) -> list[Challenge]:
    """Return the challenges of all `WWW-Authenticate` headers."""
    found = []
    for value in values:
        starts = list(_CHALLENGE.finditer(value))
        for number, start in enumerate(starts):
            end = starts[number + 1].start() if number + 1 < len(starts) else len(value)
            found.append(
                Challenge(start.group(1).lower(), parse_parameters(value[start.end() : end]))
            )
    return found


def parse_parameters(text: str) -> dict[str, str]:
    """Return `name=value` and `name="value"` pairs, names in small letters."""
    return {
        match.group(1).lower(): (
            match.group(3) if match.group(2) is None else re.sub(r"\\(.)", r"\1", match.group(2))
        )
        for match in _PARAMETER.finditer(text)
    }


def basic_authorization(user: str, password: str) -> str:
    """Return the header that carries user and password as they are."""
    pair = base64.b64encode(f"{user}:{password}".encode()).decode("ascii")
    return f"Basic {pair}"


def digest_response(
    *,
    algorithm: str,
    user: str,
    realm: str,
    password: str,
    method: str,
    uri: str,
    nonce: str,
    quality: str,
    count: str,
    client_nonce: str,
) -> str:
    """Return the response of a digest (RFC 7616, 3.4.1; without quality as RFC 2069)."""

    def hashed(text: str) -> str:
        return _HASHES[algorithm](text.encode()).hexdigest()

    secret, request = hashed(f"{user}:{realm}:{password}"), hashed(f"{method}:{uri}")
    if not quality:
        return hashed(f"{secret}:{nonce}:{request}")
    return hashed(f"{secret}:{nonce}:{count}:{client_nonce}:{quality}:{request}")


class Credentials:
    """A user with a password, and what the server wants to see of them.

    Digest is preferred, since it does not send the password. A challenge is kept, so
    that only the first request is turned down.

    Args:
        user: Name of the user; empty for none.
        password: Password, never part of any text that this class makes for people.
        client_nonce: Draws the client's random word.
    """

    def __init__(
        self,
        user: str,
        password: str,
        client_nonce: Callable[[], str] = lambda: secrets.token_hex(8),
    ) -> None:
        self._user = user
        self._password = password
        self._client_nonce = client_nonce
        self._challenge: Challenge | None = None
        self._count = 0

    def __repr__(self) -> str:
        """Return a text without the password."""
        return f"Credentials(user={self._user!r})"

    @property
    def is_known(self) -> bool:
        """Whether there is a user at all."""
        return bool(self._user)

    def learn(self, values: Sequence[str]) -> bool:
        """Take a refusal's challenges; return whether asking again makes sense.

        It does after the first challenge and after one whose only complaint is that the
        nonce is old; not when user or password were refused.
        """
        usable = [one for one in parse_challenges(values) if one.is_usable]
        usable.sort(key=lambda one: one.scheme != "digest")
        if not self.is_known or not usable:
            return False
        best, before = usable[0], self._challenge
        is_old = best.parameters.get("stale", "").lower() == "true"
        is_new = before is None or before.scheme != best.scheme or is_old
        self._challenge, self._count = best, 0
        return is_new

    def header(self, method: str, uri: str) -> str | None:
        """Return the `Authorization` header of a request, or None before any challenge."""
        if self._challenge is None:
            return None
        if self._challenge.scheme == "basic":
            return basic_authorization(self._user, self._password)
        return self._digest(self._challenge, method, uri)

    def _digest(self, challenge: Challenge, method: str, uri: str) -> str:
        self._count += 1
        told = challenge.parameters
        quality = "auth" if "qop" in told else ""
        count, client_nonce = f"{self._count:08x}", self._client_nonce()
        response = digest_response(
            algorithm=challenge.algorithm,
            user=self._user,
            realm=told.get("realm", ""),
            password=self._password,
            method=method,
            uri=uri,
            nonce=told["nonce"],
            quality=quality,
            count=count,
            client_nonce=client_nonce,
        )
        quoted = {
            "username": self._user,
            "realm": told.get("realm", ""),
            "nonce": told["nonce"],
            "uri": uri,
            "response": response,
        }
        if "opaque" in told:
            quoted["opaque"] = told["opaque"]
        words = [f'{name}="{_escaped(value)}"' for name, value in quoted.items()]
        words.append(f"algorithm={challenge.algorithm}")
        if quality:
            words += [f"qop={quality}", f"nc={count}", f'cnonce="{client_nonce}"']
        return f"Digest {', '.join(words)}"


def _escaped(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"')
