"""Learns what the store's own blocks look like, and says whether that still holds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from pydantic import JsonValue

from calibration.catalogue import Site
from calibration.errors import CalibrationError, FitFailed
from calibration.procedure import Procedure, ask_choice, ask_numbers, ask_whole
from calibration.recognition import judge
from calibration.recognition.fitting import (
    Tried,
    colour_profiles,
    fit_colours,
    fit_kinds,
    nearest_pairs,
    try_held_out,
)
from calibration.recognition.looking import (
    Seen,
    look_by_hand,
    look_with_arm,
    seeing_cameras,
    table_of,
)
from calibration.recognition.samples import BlockSample
from calibration.record import Accuracy, CalibrationRecord, Measurement, Parameter, Region, Sample
from calibration.verdict import Finding, Grade, worst
from cell.profile import LearnedKindProfile, RecognitionProfile
from cell.store import StorePlan, StoreSlot
from cell.vision.colour_model import ColourModel
from cell.vision.learned import colour_model
from cell.vision.tables import COLOURS, KINDS

KIND: Final = "recognition"
_WAYS: Final = ("arm", "by-hand")
_MOST_MEAN_DISTANCE = 2.5
_MOST_ROUNDS = 20


def learn_recognition(site: Site) -> Procedure:
    """Lay the store's blocks out, look at them, and learn their colours and sizes."""
    profile, plan, names = seeing_cameras(site)
    default = "top" if "top" in names else names[0]
    camera = yield from ask_choice("camera", "Which camera?", names, default=default)
    numbers = yield from ask_numbers(
        "slots",
        "The blocks of which slots shall it learn from?",
        default=tuple(float(slot.number) for slot in plan.slots),
    )
    slots = _chosen(plan, numbers)
    rounds = yield from ask_whole(
        "rounds",
        "How often shall they be laid out, each time elsewhere?",
        low=1,
        high=_MOST_ROUNDS,
        default=2,
    )
    moves = profile.manipulation.enabled and profile.arm.enabled and profile.gripper.enabled
    way = yield from ask_choice(
        "way", "Who lays them out?", _WAYS, default="arm" if moves else "by-hand"
    )
    table = table_of(profile, plan, camera)
    lay = look_with_arm if way == "arm" else look_by_hand
    seen = yield from lay(table, slots, rounds)
    return _learned(camera, seen)


def check_recognition(site: Site, record: CalibrationRecord) -> Procedure:
    """Look at one block of each colour, and see whether what was learned tells it."""
    profile, plan, _ = seeing_cameras(site)
    learned = RecognitionProfile.model_validate(record.values.get("recognition"))
    firsts = {slot.colour: float(slot.number) for slot in reversed(plan.slots)}
    numbers = yield from ask_numbers(
        "slots", "Which blocks shall be looked at?", default=tuple(sorted(firsts.values()))
    )
    table = table_of(profile, plan, learned.camera)
    seen = yield from look_with_arm(table, _chosen(plan, numbers), 1)
    model = colour_model(learned)
    findings = [*seen.findings, *judge.sample_findings((), seen.missing)]
    guesses = [(s, model.classify(s.mean_rgb)) for s in seen.samples]
    wrong = [s for s, g in guesses if g.colour not in (None, s.colour)]
    unsure = [s for s, g in guesses if g.colour is None]
    right = len(guesses) - len(wrong) - len(unsure)
    if wrong or 2 * len(unsure) > len(guesses):
        findings.append(_no_longer([*wrong, *unsure], len(guesses), Grade.BAD))
    elif unsure or _mean([g.distance for _, g in guesses]) > _MOST_MEAN_DISTANCE:
        findings.append(_no_longer(unsure, len(guesses), Grade.DEGRADED))
    return Measurement(
        kind=KIND,
        subject=record.subject,
        method="fresh blocks told by what was learned",
        samples=tuple(_sample(s, model) for s in seen.samples),
        accuracy=_accuracy(len(guesses), right, "fresh looks"),
        region=record.region,
        findings=tuple(findings),
        based_on=(record.identity,),
    )


def _learned(camera: str, seen: Seen) -> Measurement:
    samples = seen.samples
    findings = [*seen.findings, *judge.sample_findings(samples, seen.missing)]
    usable = [s for s in samples if not s.is_clipped]
    try:
        model = fit_colours(usable, f"the store's own blocks, {len(usable)} samples")
    except FitFailed as error:
        findings.append(Finding(code="too-few-samples", grade=Grade.BAD, text=str(error)))
        return Measurement(
            kind=KIND, subject=camera, method="not learned", findings=tuple(findings)
        )
    tried = try_held_out(usable)
    kinds = fit_kinds(usable)
    findings += judge.mixed_up(usable)
    findings += judge.colour_findings(model, tried)
    findings += judge.kind_findings(kinds)
    learned = RecognitionProfile(
        camera=camera, origin=model.origin, colours=colour_profiles(model), kinds=kinds
    )
    values: dict[str, JsonValue] = {}
    if worst(findings) is not Grade.BAD:
        values["recognition"] = learned.model_dump(mode="json")
    return Measurement(
        kind=KIND,
        subject=camera,
        method="colours as normal distributions of channel ratios with a pooled scatter; kinds "
        "as 99.9 % ranges of area and circularity",
        samples=tuple(
            _sample(s, model, seen.pictures[0].digest if i == 0 else "")
            for i, s in enumerate(usable)
        ),
        parameters=_parameters(model),
        accuracy=_accuracy(tried.count, tried.right, tried.how),
        region=Region(text=f"blocks under camera {camera} with the lights on"),
        findings=tuple(findings),
        values=values,
        details=_details(usable, model, kinds, tried),
        not_known=("how blocks look that are not in the store",),
    )


def _details(
    samples: Sequence[BlockSample],
    model: ColourModel,
    kinds: dict[str, LearnedKindProfile],
    tried: Tried,
) -> dict[str, JsonValue]:
    """Return what was learned beside the reference's tables."""
    by_tables = [s.is_right_by_tables for s in samples]
    colours: dict[str, JsonValue] = {}
    for name in model.colours:
        own = [s.mean_rgb for s in samples if s.colour == name]
        table = next((c for c in COLOURS if c.colour == name), None)
        colours[name] = {
            "learned_rgb": [round(_mean([rgb[c] for rgb in own]), 1) for c in range(3)],
            "seen_from": [min(rgb[c] for rgb in own) for c in range(3)],
            "seen_to": [max(rgb[c] for rgb in own) for c in range(3)],
            "reference": None
            if table is None
            else [[r.low, r.high] for r in (table.red, table.green, table.blue)],
        }
    shapes: dict[str, JsonValue] = {}
    for kind, learned in kinds.items():
        row = next((k for k in KINDS if k.kind == kind), None)
        shapes[kind] = {
            "area_px": list(learned.area_px),
            "circularity": list(learned.circularity),
            "reference_area_px": None if row is None else [row.area_px.low, row.area_px.high],
            "reference_circularity": None
            if row is None
            else [row.circularity.low, row.circularity.high],
        }
    return {
        "colours": colours,
        "kinds": shapes,
        "margins": [[a, b, round(margin, 2)] for a, b, margin in nearest_pairs(model)],
        "right_by_reference_tables": {
            "kinds": sum(kind for kind, _ in by_tables),
            "colours": sum(colour for _, colour in by_tables),
            "of": len(samples),
        },
        "held_out": {
            "of": tried.count,
            "right": tried.right,
            "no_colour": tried.abstained,
            "wrong": len(tried.wrong),
            "least_margin": round(tried.least_margin, 2),
        },
    }


def _parameters(model: ColourModel) -> tuple[Parameter, ...]:
    names = ("ln R/G", "ln B/G", "ln G")
    return tuple(
        Parameter(
            name=f"{one.colour} {name}",
            value=one.mean[axis],
            deviation=one.covariance[axis][axis] ** 0.5,
        )
        for one in model.classes
        for axis, name in enumerate(names)
    )


def _sample(sample: BlockSample, model: ColourModel, picture: str = "") -> Sample:
    guess = model.classify(sample.mean_rgb)
    return Sample(
        label=f"slot {sample.slot} ({sample.colour} {sample.kind}), {sample.label}",
        given=(sample.u_px, sample.v_px),
        measured=(*sample.mean_rgb, float(sample.area_px), sample.circularity),
        residual=(guess.distance,),
        picture=picture,
    )


def _accuracy(count: int, right: int, how: str) -> Accuracy:
    return Accuracy(
        held_out_rms=100.0 * (1.0 - right / count) if count else None,
        held_out_count=count,
        how=how,
        unit="% wrong or without a colour",
    )


def _no_longer(samples: Sequence[BlockSample], count: int, grade: Grade) -> Finding:
    blocks = ", ".join(str(s.slot) for s in samples)
    told = f"blocks of the slots {blocks} are" if samples else "colours as a whole are"
    return Finding(
        code="looks-changed",
        grade=grade,
        text=f"{told} not as they were learned ({len(samples)} of {count})",
        hint="check the camera's settings first (`cell calibration check`), then learn again",
    )


def _chosen(plan: StorePlan, numbers: Sequence[float]) -> list[StoreSlot]:
    known = {slot.number: slot for slot in plan.slots}
    unknown = [n for n in numbers if round(n) not in known]
    if unknown:
        listed = ", ".join(f"{n:g}" for n in unknown)
        raise CalibrationError(f"the store has no slot {listed}; it has {sorted(known)}")
    return [known[round(n)] for n in numbers]


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values) if values else 0.0
