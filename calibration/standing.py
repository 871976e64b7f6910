"""What a procedure has brought about and still counts on: screen, lights, features, blocks."""

from __future__ import annotations

from calibration.requests import (
    Light,
    MoveTool,
    PutBlock,
    Request,
    ReturnBlock,
    SetFeature,
    Show,
    StandAside,
)


class Standing:
    """Follows the requests of a run, to bring about again what the last of them left."""

    def __init__(self) -> None:
        self._light: Light | None = None
        self._show: Show | None = None
        self._features: dict[tuple[str, str], SetFeature] = {}
        self._blocks: dict[int, PutBlock] = {}
        self._arm: StandAside | MoveTool | None = None

    def follow(self, request: Request) -> None:
        """Note what a request that was answered has changed."""
        match request:
            case Light():
                self._light = request
            case Show():
                self._show = request
            case SetFeature():
                self._features[request.camera, request.feature] = request
            case PutBlock():
                self._blocks[request.slot] = request
                self._arm = None
            case ReturnBlock():
                self._blocks.pop(request.slot, None)
                self._arm = None
            case StandAside() | MoveTool():
                self._arm = request
            case _:
                pass

    @property
    def blocks(self) -> tuple[PutBlock, ...]:
        """The blocks that lie out, each where it was put last."""
        return tuple(self._blocks.values())

    def others(self) -> tuple[Request, ...]:
        """Return what brings the rest about again, in the order in which it is to be done."""
        wanted = (self._light, self._show, *self._features.values(), self._arm)
        return tuple(request for request in wanted if request is not None)
