"""Episodes of a task over a client connection, and the policies that play them."""

from __future__ import annotations

import random
import re
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

from console.exits import ConsoleError
from sessions.client import ActionReply, MasClient, View
from sessions.errors import CommandRefused
from sessions.wire.dialects import Teacher

EpisodeEnd = Literal["finished", "failed", "given up"]

_REPEATED = re.compile(r"([^*,\s]+)(?:\*(\d{1,4}))?\Z")
_ENDS: dict[str, EpisodeEnd] = {"FINISHED": "finished", "FAILED": "failed"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """How an episode went.

    Attributes:
        number: Counts the episodes of an experiment from 1.
        outcome: How it ended; `given up` after the most steps, or when the policy had none left.
        steps: How many actions were carried out.
        reward: Sum of the rewards.
        actions: The actions.
        rewards: The rewards.
        view_bytes: Bytes of views that were fetched.
        duration_s: How long it took, in real time.
    """

    number: int
    outcome: EpisodeEnd
    steps: int
    reward: float
    actions: tuple[str, ...]
    rewards: tuple[float, ...]
    view_bytes: int
    duration_s: float

    @property
    def steps_per_s(self) -> float:
        """Actions a second, in real time."""
        return self.steps / self.duration_s if self.duration_s > 0 else 0.0


class Policy(Protocol):
    """Where actions come from."""

    needs_teacher: bool

    def episode(self, actions: Sequence[str]) -> Iterator[str]:
        """Return the actions of one episode; the teacher's policy has none of its own."""


class TeacherPolicy:
    """Does what the server suggests."""

    needs_teacher = True

    def episode(self, actions: Sequence[str]) -> Iterator[str]:
        """Return nothing: suggestions come with the replies."""
        return iter(())


class RandomPolicy:
    """Draws every action from a seed."""

    needs_teacher = False

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)

    def episode(self, actions: Sequence[str]) -> Iterator[str]:
        """Yield actions without end."""
        while True:
            yield self._random.choice(actions)


class ScriptedPolicy:
    """Does the same actions in every episode."""

    needs_teacher = False

    def __init__(self, actions: Sequence[str]) -> None:
        self._actions = tuple(actions)

    def episode(self, actions: Sequence[str]) -> Iterator[str]:
        """Return the actions of the script."""
        return iter(self._actions)


def policy_named(text: str, seed: int) -> Policy:
    """Return the policy of an option: `teacher`, `random` or `script:UP,RIGHT*3`.

    Raises:
        ConsoleError: There is no such policy.
    """
    if text == "teacher":
        return TeacherPolicy()
    if text == "random":
        return RandomPolicy(seed)
    if text.startswith("script:"):
        return ScriptedPolicy(_scripted(text.removeprefix("script:")))
    raise ConsoleError(
        f"there is no policy {text!r}; there are teacher, random, script:UP,UP,RIGHT"
    )


def _scripted(text: str) -> list[str]:
    actions: list[str] = []
    for part in text.split(","):
        match = _REPEATED.match(part.strip())
        if match is None:
            raise ConsoleError(f"{part!r} is no action; script:UP,UP,RIGHT*3 would be a policy")
        actions += [match[1]] * int(match[2] or 1)
    return actions


@dataclass(slots=True)
class Choices:
    """What a task offers, and what its teacher suggests next."""

    actions: tuple[str, ...]
    views: tuple[str, ...]
    suggestion: str

    @classmethod
    def begin(
        cls, client: MasClient, goal: str, environment: str, seed: int | None, policy: Policy
    ) -> Choices:
        """Take the cell and set a task up.

        Raises:
            ConsoleError: The policy needs a teacher, and the task has none.
            ClientError: The server refuses, or the connection breaks.
        """
        if policy.needs_teacher and client.dialect.teacher is Teacher.NONE:
            raise _no_teacher(client, environment)
        if seed is not None and "USE_GLOBAL_SEED" in client.dialect.verbs:
            client.use_seed(seed)
        offer = client.initialize_task(goal, environment)
        client.begin_setup()
        suggestion = client.end_setup()
        has_teacher = bool(suggestion) or _turn_teaching_on(client)
        if policy.needs_teacher and not has_teacher:
            raise _no_teacher(client, environment)
        views = tuple(view.name for view in offer.views)
        return cls(offer.actions, views, suggestion)

    def start_over(self, client: MasClient) -> None:
        """Go back to the task's start."""
        self.suggestion = client.reset_task()


def _no_teacher(client: MasClient, environment: str) -> ConsoleError:
    return ConsoleError(
        f"{environment} in dialect {client.dialect.version} has no teacher; "
        "choose --policy random or script:..."
    )


def _turn_teaching_on(client: MasClient) -> bool:
    if "TEACHING" not in client.dialect.verbs:
        return False
    try:
        client.teaching(is_on=True)
    except CommandRefused:
        return False
    return True


def play_episode(
    client: MasClient,
    choices: Choices,
    policy: Policy,
    *,
    number: int,
    with_views: bool,
    max_steps: int,
    on_step: Callable[[int, str, ActionReply], None] | None = None,
    on_view: Callable[[int, View], None] | None = None,
) -> Episode:
    """Play one episode from the start of the task.

    Args:
        client: A connection whose task is ready.
        choices: What the task offers.
        policy: Where actions come from.
        number: Number of the episode.
        with_views: Whether every view is fetched after every action.
        max_steps: After how many steps to give up.
        on_step: Told number, action and reply of every step.
        on_view: Given every view with the number of its step.
    """
    planned = policy.episode(choices.actions)
    actions: list[str] = []
    rewards: list[float] = []
    outcome: EpisodeEnd = "given up"
    view_bytes = 0
    started_s = time.perf_counter()
    while outcome == "given up" and len(actions) < max_steps:
        action = _next(choices, policy, planned, is_first=not actions)
        if not action:
            break
        reply = client.action(action)
        choices.suggestion = reply.suggestion
        actions.append(action)
        rewards.append(reply.reward)
        if on_step is not None:
            on_step(len(actions), action, reply)
        for name in choices.views if with_views else ():
            view = client.get_view(name)
            view_bytes += len(view.data)
            if on_view is not None:
                on_view(len(actions), view)
        outcome = _ENDS.get(reply.state, "given up")
    return Episode(
        number=number,
        outcome=outcome,
        steps=len(actions),
        reward=sum(rewards),
        actions=tuple(actions),
        rewards=tuple(rewards),
        view_bytes=view_bytes,
        duration_s=time.perf_counter() - started_s,
    )


def _next(choices: Choices, policy: Policy, planned: Iterator[str], *, is_first: bool) -> str:
    if not policy.needs_teacher:
        return next(planned, "")
    # Most dialects let the teacher speak only after an action, so the first one is a guess.
    return choices.suggestion or (choices.actions[0] if is_first else "")
