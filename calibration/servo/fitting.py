"""Servo maps and sag together, from sights of a marker on the gripper.

Parameters are, for each joint, how far it turns beyond the command at knots spread evenly over
the commanded range, and four figures of sag. The model is that of `cell.kinematics.servo_map`,
with its cubic in the form that is linear in the knots.

- The upper arm's own weight turns J2 by a function of J2 alone; no sight tells it from J2's map.
- Sag beyond the elbow is told from the maps only by poses with the same command at one joint
  and the others elsewhere: the same reach, and another.
- Knots bend little: the second difference of neighbouring ones is taken to be `BEND_DEG` large
  (one standard deviation). It matters where few sights lie and is part of the covariance.
- A map that would fall is held to rise by a tenth of its command.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.least_squares import Fit, fit
from calibration.servo.chain import MarkerChain, rotations_of, turn_between
from calibration.servo.samples import BACK, JOINTS, TOP, MarkerNoise, Mount, Sight
from calibration.statistics import mahalanobis_squared, region_factor, t_quantile
from cell.errors import ProfileError
from cell.kinematics.lynx import LynxGeometry
from cell.kinematics.servo_map import ArmCorrection, SagModel, ServoMap, basis

Array = NDArray[np.float64]

BEND_DEG: Final = 2.0
_KNOT_DEG: Final = 22.0
_LEAST_KNOTS: Final = 3
_MOST_KNOTS: Final = 9
_LEAST_RISE: Final = 0.1
_HELD: Final = 1e4
_SETTLE: Final = 15
SAG_NAMES: Final = ("shoulder", "elbow", "wrist", "hand_share")
USUAL_SHARE: Final = 0.3
"""Of a hand of 100 g, 60 mm long, behind a forearm of 150 g; held where it is not seen."""
_SHARE_SEEN: Final = 0.3
_SAG_SEEN_DEG: Final = 1.5
_SAG_CHOICES: Final[tuple[tuple[int, ...], ...]] = ((), (3,), (2, 3), (0, 1, 2, 3))
"""Which figures of sag to hold, in the order in which it is tried."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ServoFit:
    """Fitted maps and sag.

    Attributes:
        correction: The maps and sag.
        knots_deg: Commanded angles of each joint's knots.
        covariance: Of all parameters: knots of J1 to J5 (deg), then `SAG_NAMES`; zero for held.
        held: Names of what the sights do not tell.
        freedom: Degrees of freedom of the noise.
        noise_factor: How much larger the noise is than stated.
        flat: Joints whose map had to be kept from falling.
        fit: The fit, in standard deviations: six figures a sight that are used, then what is
            known of bends.
        free: Indices of fitted parameters.
    """

    correction: ArmCorrection
    knots_deg: tuple[Array, ...]
    covariance: Array
    held: tuple[str, ...]
    freedom: int
    noise_factor: float
    flat: tuple[str, ...]
    fit: Fit
    free: NDArray[np.intp]

    @property
    def parameters(self) -> Array:
        """All parameters, as in `covariance`: reached angles at knots, then sag."""
        sag = self.correction.sag
        reached = [y for m in self.correction.maps for _, y in m.knots_deg]
        figures = [sag.shoulder_deg, sag.elbow_deg, sag.wrist_deg, sag.hand_share]
        return np.array([*reached, *figures])

    def band_deg(self, joint: int, *, probability: float = 0.95) -> Array:
        """Return the pointwise half band at a joint's knots, degrees; each holds by itself."""
        at = self._knots_of(joint)
        deviation = np.sqrt(np.diag(self.covariance)[at])
        return np.asarray(t_quantile(probability, self.freedom) * deviation)

    def simultaneous_band_deg(self, joint: int, *, probability: float = 0.95) -> Array:
        """Return the half band that holds all of a joint's knots together (Scheffé)."""
        at = self._knots_of(joint)
        deviation = np.sqrt(np.diag(self.covariance)[at])
        return np.asarray(np.sqrt(region_factor(at.size, self.freedom, probability)) * deviation)

    def holds(self, truth: Array, probability: float = 0.95) -> bool:
        """Return whether the joint region of all that was fitted contains true parameters."""
        at = self.free
        offset = (truth - self.parameters)[at]
        distance = mahalanobis_squared(offset, self.covariance[np.ix_(at, at)])
        return distance <= region_factor(at.size, self.freedom, probability)

    def _knots_of(self, joint: int) -> NDArray[np.intp]:
        first = sum(k.size for k in self.knots_deg[:joint])
        return np.arange(first, first + self.knots_deg[joint].size)


class ServoModel:
    """Residuals and slopes of sights by the parameters."""

    def __init__(
        self,
        sights: Sequence[Sight],
        geometry: LynxGeometry,
        mounts: Sequence[Mount],
        noise: MarkerNoise,
        knots: Sequence[Array] | None = None,
    ) -> None:
        by_name = {mount.name: mount.tool_from_marker for mount in mounts}
        unknown = sorted({sight.mount for sight in sights} - set(by_name))
        if unknown:
            raise FitFailed(
                f"no mount {unknown[0]!r} is known; there are {', '.join(sorted(by_name))}"
            )
        self.chain = MarkerChain(geometry, [by_name[sight.mount] for sight in sights])
        self.commanded = np.array([sight.commanded_deg for sight in sights], np.float64)
        self.knots = tuple(knots or (_knots(self.commanded[:, i], i) for i in range(5)))
        self._bases = [basis(k, self.commanded[:, i]) for i, k in enumerate(self.knots)]
        self._ends = np.cumsum([0, *(k.size for k in self.knots)])
        self.seen_mm = np.array([(s.seen.x_mm, s.seen.y_mm, s.seen.z_mm) for s in sights])
        self._seen_turn = rotations_of([sight.seen for sight in sights])
        self._units = noise.units
        self._used = np.tile(noise.used, len(sights))
        self._bends = self._bend_rows()
        self.count = int(self._ends[-1]) + 4
        self._kept: tuple[Array, tuple[Array, Array, Array]] | None = None

    def start(self) -> Array:
        """Return maps that do as told, and a little sag."""
        return np.array([*np.concatenate(self.knots), 0.5, 0.5, 0.1, USUAL_SHARE])

    def reached(self, p: Array) -> tuple[Array, Array]:
        """Return reached joints (n, 5) and their slopes (n, 5, p) by the parameters."""
        rest = np.stack([b @ p[self._part(i)] for i, b in enumerate(self._bases)], axis=1)
        sag = _sag_of(p)
        joints = _settled(rest, sag)
        slopes = np.zeros((len(joints), 5, p.size))
        for index, matrix in enumerate(self._bases):
            slopes[:, index, self._part(index)] = matrix
        forearm = np.radians(joints[:, 1] + joints[:, 2])
        hand = np.radians(joints[:, 1:4].sum(axis=1))
        beyond = np.cos(forearm) + sag.hand_share * np.cos(hand)
        slopes[:, 1, -4] = slopes[:, 2, -3] = beyond
        slopes[:, 3, -2] = np.cos(hand)
        slopes[:, 1, -1] = sag.shoulder_deg * np.cos(hand)
        slopes[:, 2, -1] = sag.elbow_deg * np.cos(hand)
        # A turn lessens or adds to itself: reached = (1 - d sag / d reached)^-1 of the rest.
        by_forearm = -np.sin(forearm) * np.pi / 180.0
        by_hand = -np.sin(hand) * np.pi / 180.0
        give = np.zeros((len(joints), 5, 5))
        for row, factor in ((1, sag.shoulder_deg), (2, sag.elbow_deg)):
            give[:, row, 1:3] = (factor * (by_forearm + sag.hand_share * by_hand))[:, None]
            give[:, row, 3] = factor * sag.hand_share * by_hand
        give[:, 3, 1:4] = (sag.wrist_deg * by_hand)[:, None]
        return joints, np.linalg.inv(np.eye(5) - give) @ slopes

    def six(self, p: Array) -> Array:
        """Return predicted less seen of each sight, (n, 6): mm and radians."""
        position, rotation, _ = self._at(p)
        return np.concatenate(
            [position - self.seen_mm, turn_between(rotation, self._seen_turn)], axis=1
        )

    def residuals(self, p: Array) -> Array:
        """Return the used figures of the sights and the bends, in standard deviations."""
        sights = (self.six(p) * self._units).ravel()[self._used]
        deviation = p[: self._ends[-1]] - np.concatenate(self.knots)
        return np.concatenate([sights, self._bends @ deviation])

    def slopes(self, p: Array) -> Array:
        """Return the Jacobian of `residuals`."""
        six = self._at(p)[2] * self._units[:, None]
        bends = np.zeros((len(self._bends), p.size))
        bends[:, : self._ends[-1]] = self._bends
        return np.concatenate([six.reshape(-1, p.size)[self._used], bends])

    def gripper_slopes(self, p: Array) -> Array:
        """Return how the parameters move the marker's place, (n, 3, p) in mm."""
        return self._at(p)[2][:, :3]

    def _at(self, p: Array) -> tuple[Array, Array, Array]:
        """Return places, rotations and the six figures' slopes by the parameters, kept for p."""
        if self._kept is None or not np.array_equal(self._kept[0], p):
            joints, by_parameters = self.reached(p)
            position, rotation, by_joints = self.chain.places(joints)
            self._kept = (p.copy(), (position, rotation, by_joints @ by_parameters))
        return self._kept[1]

    @property
    def bends(self) -> int:
        """How many rows of the residuals are about bends."""
        return len(self._bends)

    def rises(self, p: Array) -> list[tuple[int, int, float]]:
        """Return joint, index and missing rise (deg) of each piece that rises too little."""
        found = []
        for joint, knots in enumerate(self.knots):
            rise = np.diff(p[self._part(joint)])
            missing = _LEAST_RISE * np.diff(knots) - rise
            first = int(self._ends[joint])
            found += [
                (joint, first + int(i), float(missing[i])) for i in np.nonzero(missing > 1e-6)[0]
            ]
        return found

    def correction(self, p: Array) -> ArmCorrection:
        """Return the parameters as a value of the cell."""
        maps = [
            ServoMap(tuple(zip(knots.tolist(), p[self._part(i)].tolist(), strict=True)), JOINTS[i])
            for i, knots in enumerate(self.knots)
        ]
        a, b, c, d, e = maps
        return ArmCorrection(maps=(a, b, c, d, e), sag=_sag_of(p))

    def _part(self, joint: int) -> slice:
        return slice(int(self._ends[joint]), int(self._ends[joint + 1]))

    def _bend_rows(self) -> Array:
        rows = []
        for joint, knots in enumerate(self.knots):
            for index in range(1, knots.size - 1):
                row = np.zeros(int(self._ends[-1]))
                first = int(self._ends[joint]) + index
                row[first - 1 : first + 2] = (1.0, -2.0, 1.0)
                rows.append(row / BEND_DEG)
        return np.array(rows).reshape(-1, int(self._ends[-1]))


def fit_servos(
    sights: Sequence[Sight],
    geometry: LynxGeometry,
    *,
    mounts: Sequence[Mount] = (BACK, TOP),
    noise: MarkerNoise | None = None,
    knots: Sequence[Array] | None = None,
    steps: int = 40,
    is_trial: bool = False,
) -> ServoFit:
    """Fit maps and sag.

    Args:
        sights: Poses of the arm as the camera saw the marker.
        geometry: The arm's lengths.
        mounts: How the markers sit on the hand.
        noise: How exactly a marker is seen.
        knots: Commanded angles of each joint's knots; from the sights unless given.
        steps: Most steps of one fit; sights that fit the model need five or six.
        is_trial: Whether to give up where a map falls or sag is not seen, instead of holding
            them.

    Raises:
        FitFailed: A joint was commanded to fewer than three angles, or the sights are too few.
    """
    model = ServoModel(sights, geometry, mounts, noise or MarkerNoise(), knots)
    held: tuple[int, ...] = ()
    found: Fit | None = None
    for held in _SAG_CHOICES[:1] if is_trial else _SAG_CHOICES:
        found = _fitted(model, held, steps)
        if found is not None:
            break
    if found is None:
        raise FitFailed(
            f"{len(sights)} sights do not tell the {model.count - 4} knots of the five maps; "
            "move every joint in steps of 15 deg over its range, with the marker in view"
        )
    if is_trial and model.rises(_begin(model, held, found)[0]):
        raise FitFailed("a map falls; the angles or their signs are mistaken")
    values, free, risen, final = _kept_rising(model, held, found, steps)
    data = final.residuals.size - model.bends - len(risen)
    freedom = data - free.size
    if freedom < 1:
        raise FitFailed(f"{len(sights)} sights leave nothing to judge the fit by; take more")
    scale = float((final.residuals[:data] ** 2).sum()) / freedom
    covariance = np.zeros((values.size, values.size))
    covariance[np.ix_(free, free)] = final.covariance * scale
    try:
        correction = model.correction(values)
    except ProfileError as error:
        raise FitFailed(f"the sights give no map that rises: {error}") from error
    ends = np.cumsum([k.size for k in model.knots])
    flat = sorted({int(np.searchsorted(ends, index, side="right")) for index in risen})
    return ServoFit(
        correction=correction,
        knots_deg=model.knots,
        covariance=covariance,
        held=tuple(SAG_NAMES[i] for i in held),
        freedom=freedom,
        noise_factor=float(np.sqrt(scale)),
        flat=tuple(JOINTS[joint] for joint in flat),
        fit=replace(final, scale=scale),
        free=free,
    )


def _fitted(model: ServoModel, held: tuple[int, ...], steps: int) -> Fit | None:
    """Return the fit with some figures of sag held; None if the sights do not tell the rest."""
    start, free = _begin(model, held)
    try:
        found = _least(model, start, free, (), steps)
    except FitFailed:
        return None
    deviation = np.sqrt(np.diag(found.covariance))
    seen = {index: deviation[position] for position, index in enumerate(free)}
    knots = model.count - 4
    limits = (_SAG_SEEN_DEG, _SAG_SEEN_DEG, _SAG_SEEN_DEG, _SHARE_SEEN)
    if any(seen.get(knots + i, 0.0) > limit for i, limit in enumerate(limits)):
        return None
    return found


def _begin(
    model: ServoModel, held: tuple[int, ...], found: Fit | None = None
) -> tuple[Array, NDArray[np.intp]]:
    """Return parameters to begin with, or those of a fit, and the indices of free ones."""
    start = model.start()
    knots = model.count - 4
    for index in held:
        start[knots + index] = USUAL_SHARE if index == 3 else 0.0
    fixed = {knots + index for index in held}
    free = np.array([i for i in range(model.count) if i not in fixed])
    if found is not None:
        start[free] = found.parameters
    return start, free


def _kept_rising(
    model: ServoModel, held: tuple[int, ...], found: Fit, steps: int
) -> tuple[Array, NDArray[np.intp], dict[int, float], Fit]:
    """Return values, free parameters, held rises and the fit, with no map falling.

    Pieces that fall are held to the least rise, one round after the other, as rows of great
    weight.
    """
    start, free = _begin(model, held)
    values = start.copy()
    values[free] = found.parameters
    rows: dict[int, float] = {}
    for _ in range(8):
        falling = model.rises(values)
        fresh = [(index, joint) for joint, index, _ in falling if index not in rows]
        if not fresh:
            break
        all_knots = np.concatenate(model.knots)
        for index, _ in fresh:
            rows[index] = _LEAST_RISE * float(all_knots[index + 1] - all_knots[index]) * 1.001
        found = _least(model, start, free, tuple(sorted(rows.items())), steps)
        values = start.copy()
        values[free] = found.parameters
    return values, free, rows, found


def _least(
    model: ServoModel,
    start: Array,
    free: NDArray[np.intp],
    rises: tuple[tuple[int, float], ...],
    steps: int,
) -> Fit:
    def whole(part: Array) -> Array:
        values = start.copy()
        values[free] = part
        return values

    def residuals(part: Array) -> Array:
        p = whole(part)
        held = [_HELD * (p[index + 1] - p[index] - rise) for index, rise in rises]
        return np.concatenate([model.residuals(p), held])

    def slopes(part: Array) -> Array:
        matrix = model.slopes(whole(part))
        held = np.zeros((len(rises), start.size))
        for row, (index, _) in enumerate(rises):
            held[row, index], held[row, index + 1] = -_HELD, _HELD
        return np.concatenate([matrix, held])[:, free]

    return fit(
        residuals, start[free], jacobian=slopes, is_noise_known=True, tolerance=1e-5, steps=steps
    )


def _settled(rest: Array, sag: SagModel) -> Array:
    """Return where joints (n, 5) come to rest under weight."""
    joints = rest.copy()
    _, q2, q3, q4, _ = rest.T
    a, b, c = q2, q3, q4
    for _ in range(_SETTLE):
        forearm = np.cos(np.radians(a + b))
        hand = np.cos(np.radians(a + b + c))
        beyond = forearm + sag.hand_share * hand
        before = a
        a, b, c = (
            q2 + sag.shoulder_deg * beyond,
            q3 + sag.elbow_deg * beyond,
            q4 + sag.wrist_deg * hand,
        )
        if np.abs(a - before).max() < 1e-9:
            break
    joints[:, 1], joints[:, 2], joints[:, 3] = a, b, c
    return joints


def _sag_of(p: Array) -> SagModel:
    shoulder, elbow, wrist, share = (float(value) for value in p[-4:])
    return SagModel(shoulder_deg=shoulder, elbow_deg=elbow, wrist_deg=wrist, hand_share=share)


def _knots(commanded: Array, joint: int) -> Array:
    """Return evenly spread knots over what was commanded, no more than there are commands."""
    distinct = np.unique(np.round(commanded, 3)).size
    low, high = float(commanded.min()), float(commanded.max())
    if distinct < _LEAST_KNOTS or high - low < 5.0:
        raise FitFailed(
            f"{JOINTS[joint]} was commanded to {distinct} angles over {high - low:.1f} deg; "
            "three angles or more over its range are needed"
        )
    wanted = round((high - low) / _KNOT_DEG) + 1
    count = max(_LEAST_KNOTS, min(wanted, _MOST_KNOTS, distinct))
    return np.linspace(low, high, count)
