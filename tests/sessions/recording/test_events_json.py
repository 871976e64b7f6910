from __future__ import annotations

import json
import math
from dataclasses import asdict, fields
from typing import get_args, get_type_hints

import numpy as np
import pytest

from cell.events import Body, Event, LightsSwitched, MotionFinished, StepTaken
from cell.geometry import Pose
from sessions.recording.events_json import decode_event, encode_event, event_schema

SAMPLES: dict[type, object] = {int: 7, float: -0.125, str: "a 'quoted' \"ü\"\n", bool: True}


def _an_example(body: type) -> Body:
    hints = get_type_hints(body)
    values = [
        Pose(1.0, 2.0, 3.0) if hints[f.name] is Pose else SAMPLES[hints[f.name]]
        for f in fields(body)
    ]
    example: Body = body(*values)
    return example


@pytest.mark.parametrize("body", get_args(Body), ids=lambda body: body.__name__)
def test_every_event_comes_back_with_all_its_fields(body: type) -> None:
    example = _an_example(body)
    decoded = decode_event(encode_event(Event(3, 1.5, example)))
    assert decoded == {"sequence": 3, "time_s": 1.5, "type": body.__name__, **asdict(example)}


@pytest.mark.parametrize("body", get_args(Body), ids=lambda body: body.__name__)
def test_the_schema_names_every_field(body: type) -> None:
    schema = json.loads(event_schema())
    (entry,) = [one for one in schema["oneOf"] if one["title"] == body.__name__]
    assert set(entry["required"]) == {"sequence", "time_s", "type", *(f.name for f in fields(body))}


@pytest.mark.parametrize("reward", [math.inf, -math.inf, 1e300, 5e-324])
def test_odd_numbers_come_back(reward: float) -> None:
    body = StepTaken(1, "UP", 0, 1, reward, "", "")
    assert decode_event(encode_event(Event(1, 0.0, body)))["reward"] == reward


def test_numbers_of_numpy_are_written_like_others() -> None:
    body = MotionFinished(Pose(float(np.float64(1.5)), np.float64(2.5), 3))
    decoded = decode_event(encode_event(Event(1, 0.0, body)))
    assert decoded["pose"] == asdict(Pose(1.5, 2.5, 3.0))


def test_only_objects_are_events() -> None:
    assert decode_event(encode_event(Event(1, 0.0, LightsSwitched(False))))["is_on"] is False
    with pytest.raises(ValueError, match="JSON object"):
        decode_event(b"[1]")
