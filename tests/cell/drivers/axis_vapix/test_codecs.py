"""Requests, replies, parts and digests against their definitions."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from cell.drivers.axis_vapix import requests
from cell.drivers.axis_vapix.authorization import (
    Credentials,
    basic_authorization,
    digest_response,
    parse_challenges,
    parse_parameters,
)
from cell.drivers.axis_vapix.multipart import MalformedStream, MultipartReader, boundary_of
from cell.drivers.axis_vapix.replies import (
    HeadPosition,
    MalformedReply,
    error_text,
    parse_limits,
    parse_position,
    parse_presets,
    whole_jpeg,
)
from cell.drivers.axis_vapix.requests import ValueRefused

HEAD = "/axis-cgi/com/ptz.cgi?"

TARGETS: list[tuple[str, str]] = [
    (
        requests.still_target(640, 480, 30),
        "/axis-cgi/jpg/image.cgi?resolution=640x480&compression=30",
    ),
    (
        requests.stream_target(320, 240, 50, 10),
        "/axis-cgi/mjpg/video.cgi?resolution=320x240&compression=50&fps=10",
    ),
    (requests.absolute_target(30, -10, 500, None), f"{HEAD}pan=30&tilt=-10&zoom=500"),
    (requests.absolute_target(None, -10.5, None, 50), f"{HEAD}tilt=-10.5&speed=50"),
    (requests.relative_target(5, -5, 100, None), f"{HEAD}rpan=5&rtilt=-5&rzoom=100"),
    (requests.step_target("upleft"), f"{HEAD}move=upleft"),
    (requests.step_target("home"), f"{HEAD}move=home"),
    (requests.sweep_target(-100, 20), f"{HEAD}continuouspantiltmove=-100,20"),
    (requests.lens_sweep_target("zoom", -30), f"{HEAD}continuouszoommove=-30"),
    (
        requests.centre_target(10, 20, 640, 480),
        f"{HEAD}center=10,20&imagewidth=640&imageheight=480",
    ),
    (requests.preset_target("the table"), f"{HEAD}gotoserverpresetname=the+table"),
    (requests.switch_target("autofocus", is_on=False), f"{HEAD}autofocus=off"),
    (requests.lens_target("brightness", 9999), f"{HEAD}brightness=9999"),
    (requests.query_target("position"), f"{HEAD}query=position"),
    (requests.whoami_target(), f"{HEAD}whoami=1"),
    (requests.parameters_target("Brand"), "/axis-cgi/param.cgi?action=list&group=Brand"),
]


@pytest.mark.parametrize(("target", "expected"), TARGETS, ids=[t for _, t in TARGETS])
def test_a_request_reads_as_vapix_wants_it(target: str, expected: str) -> None:
    assert target == expected


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: requests.absolute_target(181, None, None, None), "pan cannot be 181 deg.*-180"),
        (lambda: requests.absolute_target(None, None, 0, None), "zoom cannot be 0.*1 to 9999"),
        (lambda: requests.absolute_target(None, None, None, 5), "nothing to move"),
        (lambda: requests.absolute_target(1, None, None, 101), "speed cannot be 101"),
        (lambda: requests.absolute_target(float("nan"), None, None, None), "pan cannot be nan"),
        (lambda: requests.relative_target(None, 361, None, None), "tilt by cannot be 361"),
        (lambda: requests.sweep_target(0, -101), "tilt speed cannot be -101 %"),
        (lambda: requests.centre_target(641, 0, 640, 480), "column cannot be 641"),
        (lambda: requests.lens_target("focus", 10000), "focus cannot be 10000"),
        (lambda: requests.still_target(640, 480, 101), "compression cannot be 101"),
        (lambda: requests.still_target(0, 480, 1), "width cannot be 0"),
        (lambda: requests.stream_target(640, 480, 1, 61), "rate cannot be 61 Hz"),
    ],
)
def test_a_value_out_of_range_is_refused_with_the_range(
    ask: Callable[[], str], message: str
) -> None:
    with pytest.raises(ValueRefused, match=message):
        ask()


def test_the_position_of_the_reference_is_read() -> None:
    body = (
        b"pan=-0.01\r\ntilt=-45.03\r\nzoom=1\r\niris=5748\r\nfocus=4642\r\nbrightness=4999\r\n"
        b"autofocus=on\r\nautoiris=off\r\n"
    )
    assert parse_position(body) == HeadPosition(
        pan_deg=-0.01,
        tilt_deg=-45.03,
        zoom=1,
        iris=5748,
        focus=4642,
        brightness=4999,
        has_autofocus=True,
        has_autoiris=False,
    )


def test_what_the_camera_does_not_tell_is_none() -> None:
    assert parse_position(b"pan=1\ntilt=2\n") == HeadPosition(pan_deg=1.0, tilt_deg=2.0)


@pytest.mark.parametrize(
    "body", [b"", b"<html>", b"pan=left", b"pan=1\nautofocus=maybe", b"\xff\xfe=1"]
)
def test_a_position_that_is_none_is_refused(body: bytes) -> None:
    with pytest.raises(MalformedReply):
        parse_position(body)


def test_limits_and_presets_are_read() -> None:
    limits = parse_limits(b"MinPan=-170\r\nMaxPan=170\r\nMinTilt=-90\r\nMaxZoom=9999\r\n")
    assert limits.pan_deg == (-170.0, 170.0)
    assert limits.tilt_deg is None
    assert limits.zoom is None
    presets = parse_presets(b"Preset Positions for camera 1\npresetposno10=store\npresetposno2=a=b")
    assert presets == {2: "a=b", 10: "store"}


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (b"Error: bad\r\nrequest", "bad request"),
        (b"# Error: Error getting param in group 'x'", "Error getting param in group 'x'"),
        (b"  ERROR", "without a reason"),
        (b"pan=1", None),
        (b"Errors=0", None),
        (b"", None),
        (b"\xff\xd8\xff", None),
    ],
)
def test_a_complaint_with_status_200_is_found(body: bytes, expected: str | None) -> None:
    assert error_text(body) == expected


def test_a_jpeg_is_taken_without_what_hangs_on_and_not_by_half() -> None:
    assert whole_jpeg(b"\xff\xd8abc\xff\xd9\r\n--") == b"\xff\xd8abc\xff\xd9"
    with pytest.raises(MalformedReply, match="half"):
        whole_jpeg(b"\xff\xd8abc")
    with pytest.raises(MalformedReply, match="no JPEG"):
        whole_jpeg(b"Error: x\xff\xd9")


# --- parts ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "content_type",
    [
        "multipart/x-mixed-replace;boundary=myboundary",
        "multipart/x-mixed-replace; boundary=--myboundary",
        'multipart/x-mixed-replace; charset=x; boundary="myboundary"',
        'Multipart/X-Mixed-Replace;boundary="--myboundary"',
    ],
)
def test_every_way_to_name_a_boundary_is_understood(content_type: str) -> None:
    assert boundary_of(content_type) == b"--myboundary"


@pytest.mark.parametrize(
    "content_type",
    [
        "",
        "image/jpeg",
        "multipart/mixed",
        "text/html;boundary=x",
        "multipart/x-mixed-replace;boundary=--",
    ],
)
def test_what_is_no_stream_is_refused(content_type: str) -> None:
    with pytest.raises(MalformedStream):
        boundary_of(content_type)


BODIES = [
    b"\xff\xd8first\xff\xd9",
    b"\xff\xd8\r\n\r\nsecond\n\xff\xd9",
    b"\xff\xd8third\r\n\xff\xd9",
]


def written(*, tells_length: bool, end: bytes = b"\r\n", preamble: bytes = b"") -> bytes:
    data = preamble
    for body in BODIES:
        length = b"Content-Length: %d%s" % (len(body), end) if tells_length else b""
        data += (
            b"--myboundary" + end + b"Content-Type: image/jpeg" + end + length + end + body + end
        )
    return data + b"--myboundary--" + end


@pytest.mark.parametrize("tells_length", [True, False])
@pytest.mark.parametrize("end", [b"\r\n", b"\n"], ids=["crlf", "lf"])
@pytest.mark.parametrize("preamble", [b"", b"\r\n", b"hello -- my\r\n"], ids=["", "line", "text"])
@pytest.mark.parametrize("piece", [1, 2, 7, 1000])
def test_parts_come_out_whole_however_the_bytes_arrive(
    tells_length: bool, end: bytes, preamble: bytes, piece: int
) -> None:
    data = written(tells_length=tells_length, end=end, preamble=preamble)
    reader = MultipartReader(b"--myboundary")
    found = [
        part.body
        for start in range(0, len(data), piece)
        for part in reader.feed(data[start : start + piece])
    ]
    assert found == BODIES


def test_after_nonsense_the_reader_goes_on_at_the_next_boundary() -> None:
    reader = MultipartReader(b"--myboundary")
    parts = reader.feed(
        b"--myboundary\r\nContent-Length: 3\r\n\r\nabcNONSENSE\r\n"
        b"--myboundary\r\nContent-Length: 2\r\n\r\nxy"
    )
    assert [part.body for part in parts] == [b"abc", b"xy"]
    assert parts[0].headers == {"content-length": "3"}


@pytest.mark.parametrize("seed", range(20))
def test_random_bytes_never_break_the_reader(seed: int) -> None:
    generator = random.Random(seed)
    reader = MultipartReader(b"--b")
    pieces = [b"--b", b"\r\n", b"\r\n\r\n", b"Content-Length: 4", b"Content-Length: x"]
    found = 0
    for _ in range(3000):
        noise = generator.randbytes(generator.randrange(8))
        found += len(reader.feed(generator.choice([noise, *pieces])))
    assert found > 0, seed


def test_a_part_that_announces_too_much_is_refused() -> None:
    with pytest.raises(MalformedStream, match="9999999999 bytes is announced"):
        MultipartReader(b"--b").feed(b"--b\r\nContent-Length: 9999999999\r\n\r\n")


@pytest.mark.parametrize("head", [b"--b\r\n", b"--b\r\n\r\n"], ids=["header", "body"])
def test_a_part_without_an_end_is_refused(head: bytes) -> None:
    reader = MultipartReader(b"--b")
    reader.feed(head)
    with pytest.raises(MalformedStream, match="has more than"):
        reader.feed(bytes(17 << 20))


# --- authorization -------------------------------------------------------------------------


def test_basic_is_that_of_the_reference() -> None:
    assert basic_authorization("root", "pass") == "Basic cm9vdDpwYXNz"


RFC_7616 = {
    "user": "Mufasa",
    "realm": "http-auth@example.org",
    "password": "Circle of Life",
    "method": "GET",
    "uri": "/dir/index.html",
    "nonce": "7ypf/xlj9XXwfDPEoM4URrv/xwf94BcCAzFZH4GiTo0v",
    "count": "00000001",
    "client_nonce": "f2/wE4q74E6zIJEtWaHKaf5wv/H5QzzpXusqGemxURZJ",
}


@pytest.mark.parametrize(
    ("algorithm", "expected"),
    [
        ("MD5", "8ca523f5e9506fed4657c9700eebdbec"),
        ("SHA-256", "753927fa0e85d155564e2e272a28d1802ca10daf4496794697cf8db5856cb6c1"),
    ],
)
def test_digests_are_those_of_rfc_7616(algorithm: str, expected: str) -> None:
    assert digest_response(algorithm=algorithm, quality="auth", **RFC_7616) == expected


def test_a_digest_without_quality_is_that_of_rfc_2069() -> None:
    response = digest_response(
        algorithm="MD5",
        user="Mufasa",
        realm="testrealm@host.com",
        password="CircleOfLife",
        method="GET",
        uri="/dir/index.html",
        nonce="dcd98b7102dd2f0e8b11d0f600bfb0c093",
        quality="",
        count="",
        client_nonce="",
    )
    assert response == "1949323746fe6a43ef61f9606e7febea"  # RFC 2069, errata 749


def test_challenges_are_read_from_one_header_or_several() -> None:
    one = 'Digest realm="a, b", nonce="n", qop="auth,auth-int", algorithm=MD5, Basic realm="c"'
    first, second = parse_challenges([one])
    assert (first.scheme, first.parameters["realm"]) == ("digest", "a, b")
    assert (second.scheme, second.parameters["realm"]) == ("basic", "c")
    assert [c.scheme for c in parse_challenges(['Basic realm="c"', 'Digest nonce="n"'])] == [
        "basic",
        "digest",
    ]
    assert parse_challenges(["Negotiate"]) == []


def test_credentials_prefer_digest_count_up_and_do_not_try_a_refused_password_again() -> None:
    credentials = Credentials("root", "pass", client_nonce=lambda: "0a4f113b")
    assert credentials.header("GET", "/x") is None
    challenges = ['Basic realm="r"', 'Digest realm="r", nonce="n1", qop="auth"']
    assert credentials.learn(challenges)
    first = parse_parameters(str(credentials.header("GET", "/x")))
    second = parse_parameters(str(credentials.header("GET", "/y")))
    assert (first["nc"], second["nc"]) == ("00000001", "00000002")
    assert second["uri"] == "/y"
    assert not credentials.learn(challenges)
    assert credentials.learn(['Digest realm="r", nonce="n2", qop="auth", stale=true'])
    assert parse_parameters(str(credentials.header("GET", "/x")))["nc"] == "00000001"
    assert "pass" not in repr(credentials)


@pytest.mark.parametrize(
    "challenge",
    [
        "",
        'Digest realm="r"',
        'Digest nonce="n", algorithm=SHA-512-256',
        'Digest nonce="n", qop="auth-int"',
    ],
)
def test_a_challenge_that_cannot_be_answered_is_not(challenge: str) -> None:
    credentials = Credentials("root", "pass")
    assert not credentials.learn([challenge])
    assert credentials.header("GET", "/") is None
