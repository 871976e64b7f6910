"""`cell experiment`: plays episodes against a server and sums them up."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from console.exits import ConsoleError, Exit
from console.options import AsJson
from console.output import put_json, put_table, say

if TYPE_CHECKING:
    from console.episodes import Episode


def experiment(
    address: str,
    /,
    *,
    goal: str = "ReachRedCube",
    environment: str = "STATIC_12x12",
    episodes: Annotated[int, Parameter(name=["--episodes", "-n"])] = 1,
    policy: Annotated[
        str, Parameter(help="teacher, random, or script:ACTION,ACTION,... as script:UP,RIGHT*3.")
    ] = "teacher",
    seed: int = 0,
    views: Annotated[
        bool, Parameter(negative="", help="Fetch every view after every action.")
    ] = False,
    max_steps: int = 200,
    timeout: Annotated[float, Parameter(help="Seconds that an answer may take.")] = 300.0,
    as_json: AsJson = False,
) -> int:
    """Play episodes by a policy; exit code 1 unless every episode is finished.

    Args:
        address: Where the server is, as HOST:PORT.
        goal: Name of the goal.
        environment: Name of the environment.
        episodes: How many episodes to play.
        policy: Where actions come from.
        seed: Seed of the session and of the random policy.
        views: Whether views are fetched.
        max_steps: After how many steps an episode is given up.
        timeout: How long an answer may take.
        as_json: Write JSON for programs; the same is written without, in words.
    """
    from console.episodes import Choices, play_episode, policy_named
    from console.serve import parse_address
    from sessions.client import MasClient

    if episodes < 1 or max_steps < 1:
        raise ConsoleError("--episodes and --max-steps must be 1 or more")
    chosen = policy_named(policy, seed)
    host, port = parse_address(address)
    played: list[Episode] = []
    with MasClient.connect(host, port, timeout) as client:
        choices = Choices.begin(client, goal, environment, seed, chosen)
        for number in range(1, episodes + 1):
            if number > 1:
                choices.start_over(client)
            episode = play_episode(
                client, choices, chosen, number=number, with_views=views, max_steps=max_steps
            )
            played.append(episode)
            say(
                f"episode {number} of {episodes}: {episode.outcome} after {episode.steps} steps, "
                f"reward {episode.reward:g}, {episode.steps_per_s:.0f} steps/s"
            )
    _put(played, as_json=as_json, goal=goal, environment=environment, policy=policy, seed=seed)
    return Exit.DONE if all(e.outcome == "finished" for e in played) else Exit.FAILED


def _put(
    played: list[Episode], *, as_json: bool, goal: str, environment: str, policy: str, seed: int
) -> None:
    if not as_json:
        rows = [
            (str(e.number), e.outcome, str(e.steps), f"{e.reward:g}", " ".join(e.actions))
            for e in played
        ]
        put_table(("episode", "outcome", "steps", "reward", "actions"), rows)
        return
    finished = sum(episode.outcome == "finished" for episode in played)
    put_json(
        {
            "goal": goal,
            "environment": environment,
            "policy": policy,
            "seed": seed,
            "finished": finished,
            "mean_reward": sum(e.reward for e in played) / len(played),
            "mean_steps": sum(e.steps for e in played) / len(played),
            "episodes": [{**asdict(e), "steps_per_s": e.steps_per_s} for e in played],
        }
    )
