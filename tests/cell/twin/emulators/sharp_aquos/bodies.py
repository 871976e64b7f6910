"""A panel without a world around it."""


class BarePanel:
    """A `DisplayBody` that remembers what it was told."""

    def __init__(self) -> None:
        self.is_lit = False
        self.input_number: int | None = None
        self.changes: list[tuple[float, bool, int]] = []

    def set_lit(self, *, is_lit: bool, input_number: int, now_s: float) -> None:
        self.is_lit = is_lit
        self.input_number = input_number
        self.changes.append((now_s, is_lit, input_number))
