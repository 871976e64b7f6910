from __future__ import annotations

from calibration.applying import calibrated_profile
from calibration.homography.checking import check_homography
from calibration.homography.procedure import calibrate_homography
from calibration.record import make_record
from cell.profile import load_profile
from tests.calibration.hidden_truth import hidden, with_true_lens
from tests.calibration.moment import MOMENT
from tests.calibration.playing import codes, played, site_of, twin_of


def test_a_check_passes_what_holds_and_tells_by_how_much_a_bumped_camera_is_off() -> None:
    nominal = load_profile("mash")
    truth = hidden(nominal, 4)
    profile = with_true_lens(nominal, truth)
    with twin_of(profile, truth, 4) as cell:
        found = played(calibrate_homography(site_of(profile)), {"fresh": 0.0}, cell)
        record = make_record(found, cell="mash", measured_at=MOMENT, versions={}, answers={})
        site = site_of(calibrated_profile(profile, [record]), record)
        sound = played(check_homography(site, record), {"fresh": 2.0}, cell)
        cell.behind.cameras["top"].knock(9.0, 0.0)
        bumped = played(check_homography(site, record), {"fresh": 2.0}, cell)
    assert sound.grade.value == "OK", sound.findings
    assert codes(bumped) == ["map-moved"]
    assert bumped.grade.value == "BAD"
    largest = bumped.accuracy.held_out_max
    assert largest is not None
    assert 3.5 < largest < 7.5
