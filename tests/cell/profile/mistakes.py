"""Mistakes that a profile can have: what is changed in mash, and what must be said of it."""

from __future__ import annotations

from typing import NamedTuple


class Mistake(NamedTuple):
    """One mistake.

    Attributes:
        name: What it is.
        old: Text of mash that is changed; only its first occurrence.
        new: What it becomes.
        line: A part of the line that the finding must be at.
        field: The field that the finding must name.
        message: A part of the message.
        hint: A part of the hint.
        other: A part of the other line that must be shown.
    """

    name: str
    old: str
    new: str
    line: str
    field: str
    message: str
    hint: str = ""
    other: str = ""


MISTAKES = (
    # One field by itself
    Mistake("whole number out of range", "port = 10993", "port = 70000", "port = 70000",
            "server.port", "is 70000; allowed: a whole number from 0 to 65535"),
    Mistake("number that must be above 0", "speed_mm_s = 60", "speed_mm_s = 0", "speed_mm_s = 0",
            "gripper.speed_mm_s", "is 0; allowed: a number above 0 (mm/s)"),
    Mistake("share above 100", "joint_speed_percent = 30", "joint_speed_percent = 130",
            "joint_speed_percent = 130", "arm.joint_speed_percent", "above 0, 100 at most (%)"),
    Mistake("choice that is near", 'parity = "even"', 'parity = "evn"', 'parity = "evn"',
            "arm.serial.parity", 'is "evn"; allowed: "none", "even" or "odd"',
            'did you mean "even"?'),
    Mistake("choice of numbers", "stop_bits = 2", "stop_bits = 3", "stop_bits = 3",
            "arm.serial.stop_bits", "is 3; allowed: 1 or 2"),
    Mistake("text for a number", "baud = 38400", 'baud = "38400"', 'baud = "38400"',
            "arm.serial.baud", 'is "38400"; allowed: a whole number from 50'),
    Mistake("true for a number", "robot = 1", "robot = true", "robot = true", "arm.robot",
            "is true; allowed: a whole number from 1 to 3"),
    Mistake("decimal for a whole number", "robot = 1", "robot = 1.5", "robot = 1.5", "arm.robot",
            "is 1.5; allowed: a whole number"),
    Mistake("number for a text", 'port = "COM9"', "port = 9", "port = 9", "arm.serial.port",
            "is 9; allowed: a text"),
    Mistake("text for true or false", 'model = "schunk-pg70"',
            'model = "schunk-pg70"\nenabled = "yes"', "enabled", "gripper.enabled",
            'is "yes"; allowed: true or false', "without it no block is moved"),
    Mistake("list too short", "rest_deg = [90, -30,", "rest_deg = [", "rest_deg", "arm.rest_deg",
            "(4 values); allowed: 6 numbers (deg)"),
    Mistake("list too long", "tool_mm = [0, 0,", "tool_mm = [0, 0, 0,", "tool_mm", "arm.tool_mm",
            "(4 values); allowed: 3 numbers (mm)"),
    Mistake("text within a list", "origin_mm = [710, -265]", 'origin_mm = [710, "x"]',
            'origin_mm = [710, "x"]', "lattice.origin_mm[1]", 'is "x"; allowed: a number'),
    Mistake("number for a list", "corner_mm = [-250, 700]", "corner_mm = 3", "corner_mm = 3",
            "store.corner_mm", "is 3; allowed: 2 numbers (mm)"),
    Mistake("infinity", "gain_db = -4.012", "gain_db = -inf", "gain_db = -inf",
            "cameras.top.settings.gain_db", "is -inf; allowed: a number (dB)"),
    Mistake("no number", "k1 = -0.08", "k1 = nan", "k1 = nan", "twin.cameras.oblique.k1", "is nan"),
    Mistake("number for a table", "cube = { shape =", 'cube = 7\nbox = { shape =', "cube = 7",
            "blocks.cube", "is 7; allowed: a table"),
    Mistake("name that is no name of a folder", 'name = "mash"', 'name = "ma/sh"', "ma/sh", "name",
            'is "ma/sh"; allowed: a name of letters'),
    Mistake("empty text", 'name = "table"', 'name = ""', 'name = ""', "boxes[0].name",
            "a text that is not empty"),
    Mistake("arm of another model", '"melfa-rv6sdl"', '"melfa-rv6sd"', "melfa-rv6sd", "arm.model",
            'is "melfa-rv6sd"', 'did you mean "melfa-rv6sdl"?'),
    Mistake("date that is none", "plane_map_guid", 'plane_map_date = "May"\nplane_map_guid',
            "May", "cameras.top.plane_map_date", "a date such as 2026-01-31"),
    Mistake("address that is none", "http://192.168.0.90", "camera",
            'url = "camera"', "web_camera.url", "an address such as http://"),
    Mistake("camera's address with a password", "http://192.168.0.90", "http://root:x@10.0.0.9",
            "root:x", "web_camera.url", "holds a name or a password; write the name into `user`",
            "Its address"),
    Mistake("camera's address with TLS", "http://192.168.0.90", "https://192.168.0.90",
            "https://", "web_camera.url", "an address such as http://192.168.0.90"),
    # Keys
    Mistake("key with a slip", "baud = 38400", "buad = 38400", "buad", "arm.serial.buad",
            "unknown key `buad` in [arm.serial]", "did you mean `baud`?"),
    Mistake("key of another table", "open_mm = 60", "open_mm = 60\nlaying_mm = 5", "laying_mm = 5",
            "gripper.laying_mm", "unknown key `laying_mm` in [gripper]", "it belongs in [heights]"),
    Mistake("key of nothing", "angle_deg = 0", "angle_deg = 0\nfoo = 1", "foo = 1", "store.foo",
            "unknown key `foo` in [store]", "known are corner_mm, angle_deg"),
    Mistake("table of nothing", "[heights]", "[foo]\n[heights]", "[foo]", "foo",
            "unknown key `foo` at the top of the profile", "known are name, server"),
    Mistake("a password", "[web_camera]",
            '[web_camera]\npassword = "x"', 'password = "x"',
            "web_camera.password", "unknown key `password`", "did you mean `password_variable`?"),
    Mistake("a secret", "[lattice]", '[reports]\nfile = "x"\napi_key = "x"\n[lattice]', "api_key",
            "reports.api_key", "unknown key `api_key`", "a profile holds no secrets"),
    Mistake("missing field", "surface_mm = 38.5", "# nothing", "[heights]", "heights.surface_mm",
            "[heights] has no `surface_mm`: a number (mm) is needed", "Height of the glass"),
    Mistake("missing field of an inline table", "baud = 38400, ", "", "serial = {",
            "arm.serial.baud", "[arm.serial] has no `baud`: a whole number from 50"),
    Mistake("missing model", 'model = "melfa-rv6sdl"\n', "", "[arm]", "arm.model",
            "[arm] has no `model`"),
    Mistake("missing table", "[store]                        # ours: has all slots in reach\n"
            "corner_mm = [-250, 700]\nangle_deg = 0\n", "", "", "store",
            "the profile has no table `store`"),
    # What fields must be to each other
    Mistake("joint that goes nowhere", "joint_min_deg = [-170,", "joint_min_deg = [170,",
            "joint_max_deg", "arm.joint_max_deg[0]",
            "J1 may go from 170 to 170: the greatest position must be above the least", "",
            "joint_min_deg"),
    Mistake("rest beyond a limit", "rest_deg = [90, -30,", "rest_deg = [90, -130,", "rest_deg",
            "arm.rest_deg[1]", "the arm rests with J2 at -130; -93 to 135 is allowed",
            "within the limits", "joint_min_deg"),
    Mistake("joint without speed", "joint_speed_deg_s = [250,", "joint_speed_deg_s = [0,",
            "joint_speed_deg_s", "arm.joint_speed_deg_s[0]", "the speed of J1 is 0"),
    Mistake("too fast", "linear_speed_mm_s = 250", "linear_speed_mm_s = 2500",
            "linear_speed_mm_s = 2500", "arm.linear_speed_mm_s", "1000 mm/s at most", "",
            "max_linear_speed_mm_s"),
    Mistake("two devices on one port", '"COM8"', '"com9"', "com9", "gripper.serial.port",
            'gripper and arm are both at "com9"', "its own port", "COM9"),
    Mistake("two cameras with one number", "number = 2", "number = 1", "number = 1",
            "cameras.top.number", "the cameras oblique and top both have number 1", "label",
            "number = 1"),
    Mistake("two cameras with one GUID", "00B09D01009A7C43", "00b09d01009a7c42",
            "00b09d01009a7c42", "cameras.gripper.guid", "top and gripper both have the GUID",
            "", "00B09D01009A7C42"),
    Mistake("flat plane map", "[0.58116, -0.00504, -375.536], [0.0, 1e-5, 1.0]",
            "[0.00656, 0.58748, 222.028], [0.0, 1e-5, 1.0]", "plane_map", "cameras.top.plane_map",
            "its determinant is 0"),
    Mistake("camera without a twin", "[twin.cameras.oblique]", "[twin.cameras.obliqe]",
            "[cameras.oblique]", "cameras.oblique", "[twin.cameras.oblique] is missing",
            "say where its twin stands", "[twin]"),
    Mistake("two outputs with one bit", "magnet = 10", "magnet = 8", "magnet = 8",
            "outputs.magnet", "output 8 switches both lights and magnet", "its own bit", "lights"),
    Mistake("surface above the laying height", "surface_mm = 38.5", "surface_mm = 55",
            "laying_mm = 55", "heights.laying_mm", "must be above it", "", "surface_mm"),
    Mistake("service below the laying height", "service_mm = 200", "service_mm = 50",
            "service_mm = 50", "heights.service_mm", "above the laying height", "", "laying_mm"),
    Mistake("fingertips in the glass", "tip_below_tool_mm = 12", "tip_below_tool_mm = 20",
            "laying_mm", "heights.laying_mm", "they would touch it", "above 58.5 mm",
            "tip_below_tool_mm"),
    Mistake("block below the fingers", "width_mm = 33, height_mm = 33 }",
            "width_mm = 33, height_mm = 4 }", "cube", "blocks.cube.height_mm",
            "they would close above it", "", "laying_mm"),
    Mistake("blocks that collide", "service_mm = 200", "service_mm = 80", "service_mm = 80",
            "heights.service_mm", "they would collide", "", "cube"),
    Mistake("block wider than the fingers", "open_mm = 60", "open_mm = 34", "cube",
            "blocks.cube.width_mm", "the fingers open to 34 mm: they need 2 mm more", "",
            "open_mm"),
    Mistake("oval cylinder", 'shape = "cylinder", length_mm = 33',
            'shape = "cylinder", length_mm = 40', "cylinder", "blocks.cylinder.length_mm",
            "both must be its diameter"),
    Mistake("arch larger than its block", "arch_radius_mm = 20", "arch_radius_mm = 34", "bridge",
            "blocks.bridge.arch_radius_mm", "33 mm at most fits"),
    Mistake("fingers beyond their stroke", "open_mm = 60", "open_mm = 75", "open_mm = 75",
            "gripper.open_mm", "their stroke of 70 mm is the most", "", "stroke_mm"),
    Mistake("box inside out", "max_mm = [1500, 1500, 38.5]", "max_mm = [1500, -1600, 38.5]",
            "max_mm", "boxes[0].max_mm[1]", "reaches from -1500 to -1600 mm along y", "",
            "min_mm"),
    Mistake("two boxes of one name", '"left camera pillar"', '"table"', 'name = "table"',
            "boxes[1].name", 'two boxes are called "table"'),
    # No TOML
    Mistake("no TOML", "baud = 38400", "baud = 38400 8E2", "8E2", "", "this is not TOML"),
    Mistake("key given twice", "robot = 1", "robot = 1\nrobot = 2", "robot = 2", "arm.robot",
            "`arm.robot` is given twice", "keep one", "robot = 1"),
    Mistake("table given twice", "[lattice]", "[store]\n[lattice]", "[store]", "store",
            "`store` is given twice", "keep one", "[store]"),
)  # fmt: skip

WARNINGS = (
    Mistake("map of nobody knows which camera", 'plane_map_guid = "00B09D01009A7C42"\n', "",
            "plane_map", "cameras.top.plane_map", "not noted with which camera", "plane_map_guid"),
    Mistake("map of another camera", 'plane_map_guid = "00B09D01009A7C42"',
            'plane_map_guid = "X1"', "X1", "cameras.top.plane_map_guid",
            "was measured with the camera X1", "measure", "00B09D01009A7C42"),
    Mistake("twin without a camera", "[twin.cameras.top]",
            "[twin.cameras.side]\nposition_mm = [0, 0, 0]\nrotation_deg = [0, 0, 0]\n"
            "focal_px = 1\ncentre_px = [0, 0]\n[twin.cameras.top]", "[twin.cameras.side]",
            "twin.cameras.side", "there is no [cameras.side]"),
    Mistake("port of a disabled device", 'model = "schunk-pg70"',
            'model = "schunk-pg70"\nenabled = false', "COM8", "gripper.serial.port",
            'the port "COM8" is not used: gripper is disabled', "", "enabled"),
    Mistake("port beside TCP", "robot = 1", 'robot = 1\ntcp = { host = "10.0.0.2", port = 10001 }',
            "COM9", "arm.serial.port", "the arm is reached at 10.0.0.2:10001", "", "tcp"),
    Mistake("no port at all", 'port = "COM7", ', "", "serial", "display.serial",
            "display has neither port nor usb_serial"),
    Mistake("password in an address", "[lattice]",
            '[reports.webhook]\nurl = "http://root:pass@10.0.0.9"\n[lattice]', "root:pass",
            "reports.webhook.url", "`reports.webhook.url` holds a password", "take it out"),
    Mistake("secret for a variable", "[lattice]",
            '[reports.bugzilla]\nurl = "https://b.example"\nproduct = "p"\ncomponent = "c"\n'
            'key_variable = "a8f-77/xx"\n[lattice]', "a8f-77", "reports.bugzilla.key_variable",
            "is it the secret itself?", "environment variable"),
)  # fmt: skip
