"""Every diagnostic code: how severe it is, what it means, how it is mended.

`docs/reference/diagnostics.md` is `reference_page()`, and the table at the end of
`docs/reference/language.md` has the same titles; tests compare them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Severity = Literal["error", "warning"]


@dataclass(frozen=True, slots=True)
class Code:
    """One code of the table.

    Attributes:
        code: Such as `E402`; `E` is an error, `W` a warning.
        title: What is wrong, in a few words.
        explanation: When it is reported and what to do.
    """

    code: str
    title: str
    explanation: str

    @property
    def severity(self) -> Severity:
        """Whether it keeps a script from running."""
        return "error" if self.code.startswith("E") else "warning"


_TABLE = (
    Code(
        "E101",
        "something else was expected here",
        "The text does not continue as a declaration or statement can. The message "
        "lists what may stand there. Checking goes on at the next statement.",
    ),
    Code(
        "E102",
        "a character that the language does not use",
        "Outside of texts and comments only letters, digits, `_`, `.`, the signs of "
        "numbers and `{ } ( ) , < > = #` are used. Names have ASCII letters only.",
    ),
    Code(
        "E103",
        "a text is not closed or has a wrong escape",
        'A text begins and ends with `"` in the same line and has no control '
        'characters. Inside, `\\"` is a quote and `\\\\` a backslash; there are no other '
        "escapes.",
    ),
    Code(
        "E104",
        "no such statement",
        "A declaration is one of store, action, environment and goal; which statements "
        "each may hold is in the language's reference. Often a slip of the pen.",
    ),
    Code(
        "E105",
        "a reserved word",
        "The words of the language cannot be names, nor can the words that a later "
        "version will use (such as `test` and `setting`). Choose another name.",
    ),
    Code(
        "E106",
        "a closing brace is missing",
        "A declaration begins, or the file ends, before the one before it is closed.",
    ),
    Code(
        "E107",
        "the file is too large",
        "A script has at most 500 000 characters. Nothing else was checked.",
    ),
    Code(
        "E108",
        "a statement that belongs elsewhere",
        "The statement exists, but in another sort of declaration.",
    ),
    Code(
        "E109",
        "too many problems",
        "After 100 problems the rest is left out. Often one mistake near the first "
        "causes the others.",
    ),
    Code(
        "E201",
        "declared twice",
        "Two declarations of the same sort have the same name, two slots the same "
        "number, or a script has two stores. The first one counts.",
    ),
    Code(
        "E202",
        "no such name",
        "No declaration of that sort has this name; names are case-sensitive.",
    ),
    Code(
        "E203",
        "environments extend each other in a circle",
        "An environment cannot take over from itself, neither directly nor by way of others.",
    ),
    Code(
        "E204",
        "said twice",
        "A statement that may stand once stands twice in one declaration, or a list "
        "names the same thing twice. Remove one.",
    ),
    Code(
        "E205",
        "something required is missing",
        "A declaration lacks a statement that has no default, or a block lacks a kind "
        "or colour where both are needed.",
    ),
    Code(
        "E206",
        "no such kind of block",
        "Kinds are cube, cylinder and bridge. The kind comes before the colour.",
    ),
    Code("E207", "no such colour", "Colours are red, green, blue, yellow and natural."),
    Code("E208", "no such background", "Backgrounds are black, white, mash, water and forest."),
    Code("E209", "wrong unit", "Lengths are in `mm`, angles in `deg`; there are no other units."),
    Code("E301", "a number out of range", "The message names the range."),
    Code(
        "E302",
        "not a whole number",
        "Lattice points, steps, slots and counts are whole numbers.",
    ),
    Code(
        "E303",
        "a picture size that is not offered",
        "The cameras' modes give 640x480, 800x600, 1024x768 and 1280x960.",
    ),
    Code(
        "E304",
        "a picture format that is not offered",
        "Formats are mif, ppm, pgm, png and jpeg.",
    ),
    Code(
        "E305",
        "a number too large to represent",
        "The number is larger than a 64-bit float can be.",
    ),
    Code(
        "E306",
        "a range whose end comes before its beginning",
        "In `place 6 to 3 of any` the numbers are in the wrong order.",
    ),
    Code("E307", "an empty text", "An event text says something, or there is no event."),
    Code(
        "E401",
        "outside the world",
        "The point is not one of (0, 0) to (width - 1, height - 1).",
    ),
    Code(
        "E402",
        "blocks overlap",
        "Two fixed blocks would lie in each other. Cubes and cylinders need two lattice "
        "steps along one of the axes; a bridge is three times as long.",
    ),
    Code(
        "E403",
        "no room for the fingers",
        "The fingers stand left and right of a gripped block, up to 38 mm from its "
        "centre, and are 20 mm wide. Another block lies there, so that this one could "
        "be neither laid out nor taken back.",
    ),
    Code(
        "E404",
        "more blocks than the store has",
        "More blocks of a kind and colour may be asked for than the store has slots of.",
    ),
    Code(
        "E405",
        "no layout exists",
        "Whatever the seed, the blocks cannot be placed so that they have room and keep "
        "every requirement. The message names what is to blame.",
    ),
    Code(
        "W406",
        "not every seed has a layout",
        "With the largest number of blocks that a seed may draw there is no layout; a "
        "task with such a seed ends with an error when it is set up.",
    ),
    Code(
        "E407",
        "fixed blocks break a requirement",
        "The positions that the script itself gives do not keep a `require`.",
    ),
    Code(
        "E408",
        "slots too close",
        "Blocks in two slots would overlap, or one leaves no room for the fingers that "
        "take the other.",
    ),
    Code(
        "E501",
        "the target does not lie in every environment",
        "An environment of the goal does not lay out the target for every seed. Place it "
        "there, or let the goal place it: `target cube red at random`.",
    ),
    Code(
        "E502",
        "several blocks could be the target",
        "An environment of the goal lays out, or may lay out, several blocks of the "
        "target's kind and colour. Let the goal place the target, or remove one.",
    ),
    Code(
        "W503",
        "a rule that never applies",
        "Rules are tried from the top. An earlier rule (often `otherwise`) covers all "
        "that this one could.",
    ),
    Code(
        "E504",
        "no `otherwise` rule",
        "Exactly one rule applies to each step, so the last one is `otherwise`.",
    ),
    Code("W505", "the task never ends", "No rule has `finish` or `fail`."),
    Code("W506", "the start is the target", "The gripper begins above the target."),
    Code(
        "W507",
        "no way to the target",
        "No sequence of the environment's actions leads from the start to the target.",
    ),
    Code("W601", "an unused action", "No environment lists the action."),
    Code(
        "W602",
        "an unused environment",
        "No goal offers the environment and no other environment extends it.",
    ),
    Code(
        "E701",
        "out of the arm's reach",
        "The arm of this cell cannot get to a point of the world, at the height of "
        "travel. Make the world smaller or mend the lattice in the cell's profile.",
    ),
    Code(
        "E702",
        "a slot out of the arm's reach",
        "The arm of this cell cannot grip a block in that slot. Mend the plan's place in "
        "the cell's profile or the slot.",
    ),
    Code(
        "E703",
        "out of a camera's sight",
        "A camera that the environment shows does not see a point of its world.",
    ),
    Code("E704", "no such camera", "The cell has no camera of that name."),
    Code(
        "E705",
        "a block the cell does not know",
        "The cell's profile has no such kind or colour of block.",
    ),
    Code(
        "E706",
        "not known as well as is demanded",
        "An `accuracy` demands it, and the cell's calibrations say less, or there is none: of "
        "where the lattice lies, or of where a view shows the table. Calibrate again.",
    ),
)

CODES = {code.code: code for code in _TABLE}
"""Every code, by its name, in the order of the reference."""


def reference_page() -> str:
    """Return the reference page of all diagnostics, in Markdown."""
    lines = [
        "# Diagnostics of the `.cell` language",
        "",
        "Made from `dsl/codes.py`; a test compares them. `E` is an error, which keeps a",
        "script from running, `W` a warning.",
    ]
    for code in _TABLE:
        lines += ["", f"## {code.code}: {code.title}", "", code.explanation]
    return "\n".join(lines) + "\n"
