"""The picture that was shown last, kept so that a new process can show it again."""

from __future__ import annotations

import hashlib
import json
import logging
import os
from dataclasses import dataclass
from pathlib import Path

_LOGGER = logging.getLogger(__name__)
_INDEX = "screen.json"


@dataclass(frozen=True, slots=True)
class KeptPicture:
    """A picture with its name."""

    name: str
    sha256: str
    png: bytes


class LastPicture:
    """One picture in a folder: `screen.json` names it, `screen-<sha256>.png` is it.

    The index is put in place by rename after the picture is whole, so a killed process
    leaves either the old picture or the new one.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def keep(self, picture: KeptPicture) -> None:
        """Put a picture in the place of the one before; a full disk is only logged."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            path = self._path(picture.sha256)
            if not path.exists():
                self._put(path, picture.png)
            index = {"name": picture.name, "sha256": picture.sha256}
            self._put(self._folder / _INDEX, json.dumps(index).encode("utf-8"))
            for other in self._folder.glob("screen-*.png"):
                if other != path:
                    other.unlink(missing_ok=True)
        except OSError as error:
            _LOGGER.warning("the picture on the screen is not remembered: %s", error)

    def read(self) -> KeptPicture | None:
        """Return the picture, or None when there is none or it is damaged."""
        try:
            index = json.loads((self._folder / _INDEX).read_text("utf-8"))
            name, sha256 = str(index["name"]), str(index["sha256"])
            png = self._path(sha256).read_bytes()
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError) as error:
            _LOGGER.warning("the last picture on the screen cannot be read: %s", error)
            return None
        if hashlib.sha256(png).hexdigest() != sha256:
            _LOGGER.warning("the last picture on the screen is damaged and not shown again")
            return None
        return KeptPicture(name, sha256, png)

    def _path(self, sha256: str) -> Path:
        return self._folder / f"screen-{sha256}.png"

    def _put(self, path: Path, data: bytes) -> None:
        new = path.with_name(f"{path.name}.{os.getpid()}.new")
        new.write_bytes(data)
        os.replace(new, path)
