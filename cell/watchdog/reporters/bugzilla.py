"""Files faults as bugs over Bugzilla's REST interface (5.0, 5.2 and later)."""

from __future__ import annotations

import base64
import os
from collections.abc import Mapping
from urllib.parse import quote

from cell.profile import BugzillaProfile
from cell.watchdog.evidence import Attachment
from cell.watchdog.report import Report, ReportUndelivered
from cell.watchdog.reporters.http import Answer, JsonClient

_ALIAS_TAKEN = 103
_PASSING = frozenset({32000, 504, 505})
"""Codes of failures that pass by themselves; every other refusal needs changed settings."""
_MOST_SUMMARY = 255
_MOST_DESCRIPTION = 60_000


class Bugzilla:
    """One Bugzilla; the API key travels as header and as field, as its versions differ.

    Each report has an alias, so that a bug whose answer got lost is found again instead of
    being filed twice.
    """

    def __init__(self, profile: BugzillaProfile, environment: Mapping[str, str] = os.environ):
        self._profile = profile
        self._key = environment.get(profile.key_variable, "").strip()
        self._rest = profile.url.rstrip("/") + "/rest"
        headers = {"X-BUGZILLA-API-KEY": self._key} if self._key else {}
        self._client = JsonClient(f"Bugzilla at {profile.url}", profile.timeout_s, headers)

    @property
    def name(self) -> str:
        """Name that tells it from other trackers."""
        return f"bugzilla {self._profile.url}"

    @property
    def attaches(self) -> bool:
        """Attachments go one by one."""
        return True

    def file(self, report: Report, *, may_be_known: bool) -> str:
        """File a bug and return its number.

        Raises:
            ReportUndelivered: Bugzilla is down or refuses.
        """
        self._require_key()
        if may_be_known:
            known = self._find(report.alias)
            if known:
                return known
        answer = self._client.post(f"{self._rest}/bug", self._bug(report))
        number = answer.fields.get("id")
        if answer.status in (200, 201) and isinstance(number, int):
            return str(number)
        if answer.fields.get("code") == _ALIAS_TAKEN:
            known = self._find(report.alias)
            if known:
                return known
        raise self._refusal("the bug", answer)

    def attach(self, reference: str, attachment: Attachment, *, may_be_known: bool) -> None:
        """Attach a file to a bug, unless an earlier attempt did.

        Raises:
            ReportUndelivered: Bugzilla is down or refuses.
        """
        self._require_key()
        if may_be_known and attachment.name in self._attached(reference):
            return
        answer = self._client.post(
            f"{self._rest}/bug/{reference}/attachment",
            {
                "ids": [int(reference)],
                "file_name": attachment.name,
                "summary": attachment.name,
                "content_type": attachment.mime,
                "data": base64.b64encode(attachment.data).decode(),
                "api_key": self._key,
            },
        )
        if answer.status not in (200, 201) or answer.fields.get("error"):
            raise self._refusal(f"the attachment {attachment.name}", answer)

    def _bug(self, report: Report) -> dict[str, object]:
        profile = self._profile
        return {
            "product": profile.product,
            "component": profile.component,
            "version": profile.version,
            "summary": report.summary[:_MOST_SUMMARY],
            "description": report.description[:_MOST_DESCRIPTION],
            "op_sys": "All",
            "rep_platform": "All",
            "priority": profile.priority,
            "severity": profile.severity,
            "alias": report.alias,
            "api_key": self._key,
        }

    def _find(self, alias: str) -> str:
        """Return the number of the bug of that alias, empty if there is none."""
        answer = self._client.get(f"{self._rest}/bug/{quote(alias)}?api_key={quote(self._key)}")
        bugs = answer.fields.get("bugs")
        if answer.status == 200 and isinstance(bugs, list) and bugs and isinstance(bugs[0], dict):
            return str(bugs[0].get("id", ""))
        if answer.status >= 500:
            raise self._refusal("a question", answer)
        return ""

    def _attached(self, reference: str) -> frozenset[str]:
        """Return the names of the files that a bug has."""
        answer = self._client.get(
            f"{self._rest}/bug/{reference}/attachment?exclude_fields=data&api_key={quote(self._key)}"
        )
        bugs = answer.fields.get("bugs")
        files = bugs.get(reference) if isinstance(bugs, dict) else None
        if answer.status != 200 or not isinstance(files, list):
            raise self._refusal("a question", answer)
        return frozenset(str(file.get("file_name")) for file in files if isinstance(file, dict))

    def _require_key(self) -> None:
        if not self._key:
            raise ReportUndelivered(
                f"{self.name}: the environment variable {self._profile.key_variable} holds no API "
                "key; set it where the server is started",
                is_final=True,
            )

    def _refusal(self, what: str, answer: Answer) -> ReportUndelivered:
        code, message = answer.fields.get("code"), answer.fields.get("message")
        told = f" (code {code}: {message})" if code is not None else ""
        is_passing = answer.status >= 500 or answer.status == 429 or code in _PASSING
        return ReportUndelivered(
            f"{self.name} refused {what} with HTTP {answer.status}{told}", is_final=not is_passing
        )
