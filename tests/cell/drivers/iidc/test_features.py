"""The features of an IIDC camera, on the register file of an emulated Flea2."""

from __future__ import annotations

import pytest

from cell.devices.camera_features import FEATURE_NAMES, UNITS, FeatureError, FeatureName
from cell.drivers.iidc.codec import decode_control
from cell.drivers.iidc.features import IidcFeatures
from cell.drivers.iidc.tables import CONTROL, INQUIRY, SLOTS
from cell.errors import DeviceError
from cell.twin.cameras.flea2 import Flea2Registers

ABSOLUTE: tuple[FeatureName, ...] = (
    "brightness", "exposure", "hue", "saturation", "gamma", "shutter", "gain",
)  # fmt: skip
RAW: tuple[FeatureName, ...] = tuple(
    name for name in FEATURE_NAMES if name not in (*ABSOLUTE, "frame_rate")
)


@pytest.fixture
def registers() -> Flea2Registers:
    return Flea2Registers("top")


@pytest.fixture
def features(registers: Flea2Registers) -> IidcFeatures:
    return IidcFeatures("top", registers)


def test_every_feature_of_the_table_is_there(features: IidcFeatures) -> None:
    assert tuple(feature.name for feature in features.all()) == FEATURE_NAMES
    for feature in features.all():
        assert (feature.absolute_range is not None) == (feature.name in UNITS)
        assert feature.unit == UNITS.get(feature.name, "")


@pytest.mark.parametrize("name", ABSOLUTE)
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_absolute_value_is_set_and_read_back(
    features: IidcFeatures, name: FeatureName, share: float
) -> None:
    span = features.feature(name).absolute_range
    assert span is not None
    value = round(span[0] + share * (span[1] - span[0]), 3) if 0 < share < 1 else span[int(share)]
    after = features.set_absolute(name, value)
    assert after.absolute == pytest.approx(value, rel=1e-6)
    assert (after.control, after.is_absolute, after.is_read_only) == ("manual", True, False)


@pytest.mark.parametrize("name", [*RAW, "gain", "shutter", "hue"])
def test_raw_value_is_set_and_read_back_at_both_ends(
    features: IidcFeatures, name: FeatureName
) -> None:
    span = features.feature(name).raw_range
    assert span is not None
    for value in span:
        after = features.set_raw(name, value)
        assert (after.raw, after.is_absolute, after.control) == (value, False, "manual")


def test_raw_and_absolute_follow_each_other_but_stay_apart(features: IidcFeatures) -> None:
    gain = features.set_raw("gain", 1023)
    assert (gain.raw, gain.absolute) == (1023, 24.0)
    gain = features.set_absolute("gain", -4.012)
    assert gain.absolute == -4.012
    assert gain.raw == 68


def test_white_balance_halves_do_not_disturb_each_other(features: IidcFeatures) -> None:
    features.set_raw("white_balance_red", 597)
    features.set_raw("white_balance_blue", 839)
    assert features.feature("white_balance_red").raw == 597
    assert features.feature("white_balance_blue").raw == 839


@pytest.mark.parametrize("name", ["gain", "shutter"])
@pytest.mark.parametrize("word", [0x83000000, 0xC2000000], ids=["automatic", "absolute"])
def test_raw_register_ignores_values_while_automatic_or_absolute(
    registers: Flea2Registers, name: FeatureName, word: int
) -> None:
    address = CONTROL + SLOTS[name].offset
    registers.write(address, 0x82000000)
    registers.write(address, 0x82000123)
    registers.write(address, word)
    registers.write(address, word | 0x3FF)
    assert decode_control(registers.read(address)).value == 0x123


def test_longest_shutter_doubles_when_the_rate_is_halved(
    registers: Flea2Registers, features: IidcFeatures
) -> None:
    longest = {}
    for rate_hz in (15.0, 7.5):
        registers.set_frame_rate(rate_hz)
        span = features.feature("shutter").absolute_range
        assert span is not None
        longest[rate_hz] = span[1]
    assert longest[7.5] == pytest.approx(2 * longest[15.0], rel=1e-6)


def test_shorter_frame_period_shortens_a_long_shutter(
    registers: Flea2Registers, features: IidcFeatures
) -> None:
    features.set_absolute("shutter", 500.0)
    registers.set_frame_rate(30.0)
    shutter = features.feature("shutter")
    assert shutter.absolute_range is not None
    assert shutter.absolute == shutter.absolute_range[1] < 500.0


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("shutter", 900.0, "asked 900 ms, allowed 0.01 to 533.333 ms, reads back"),
        ("gain", -7.0, "asked -7 dB, allowed -6 to 24 dB, reads back"),
        ("sharpness", 5.0, "allowed no absolute value"),
        ("frame_rate", 15.0, "reads back 7.5 frames/s \\(auto\\)"),
    ],
)
def test_refused_absolute_value_says_asked_allowed_and_read_back(
    features: IidcFeatures, name: FeatureName, value: float, text: str
) -> None:
    with pytest.raises(FeatureError, match=text):
        features.set_absolute(name, value)


@pytest.mark.parametrize("value", [1024, -1])
def test_refused_raw_value_changes_nothing(features: IidcFeatures, value: int) -> None:
    before = features.feature("gain")
    with pytest.raises(FeatureError, match=f"asked {value}, allowed 0 to 1023"):
        features.set_raw("gain", value)
    assert features.feature("gain") == before


def test_value_that_the_camera_drops_is_told(features: IidcFeatures) -> None:
    class Deaf(Flea2Registers):
        def write(self, address: int, word: int) -> None:
            """Drop it."""

    deaf = IidcFeatures("top", Deaf("top"))
    features.set_raw("pan", 100)
    with pytest.raises(FeatureError, match="pan: asked 100, allowed 0 to 4095, reads back 0"):
        deaf.set_raw("pan", 100)


def test_automatic_mode_is_read_only_and_ends_with_a_value(features: IidcFeatures) -> None:
    auto = features.set_auto("shutter", is_auto=True)
    assert (auto.control, auto.is_read_only) == ("auto", True)
    kept = features.set_auto("shutter", is_auto=False)
    assert (kept.control, kept.raw) == ("manual", auto.raw)
    features.set_auto("shutter", is_auto=True)
    assert features.set_absolute("shutter", 20.0).control == "manual"


def test_feature_without_automatic_mode_refuses_it(features: IidcFeatures) -> None:
    with pytest.raises(FeatureError, match="asked auto, allowed manual"):
        features.set_auto("pan", is_auto=True)


def test_absent_feature_is_named() -> None:
    class Bare(Flea2Registers):
        def read(self, address: int) -> int:
            return 0 if address == INQUIRY + SLOTS["hue"].offset else super().read(address)

    features = IidcFeatures("top", Bare("top"))
    assert "hue" not in {feature.name for feature in features.all()}
    with pytest.raises(FeatureError, match="hue: asked 5 deg, allowed nothing, has no such"):
        features.set_absolute("hue", 5.0)


def test_body_without_power_answers_nothing(
    registers: Flea2Registers, features: IidcFeatures
) -> None:
    registers.is_powered = False
    with pytest.raises(DeviceError, match="not on the bus"):
        features.all()
