"""Three hundred seeded sessions, each with a fault from the documents' table in its middle."""

from __future__ import annotations

import logging
import random
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from cell.events import ArmHeld, DeviceRecovered, RequestRepeated, ResumeChecked
from cell.recovery.faults import Deed, Fault, Rule
from cell.recovery.policy import POLICY
from tests.sessions.fault_rig import FaultRig, Lines, Talk, deadline
from tests.sessions.fault_scenarios import SCENARIOS, Moment, Scenario

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "faults.md"
SESSIONS = 300
CHUNKS = 20
FIRST_SEED = 7300
DEEDS = {deed.value: deed for deed in Deed}
FAULTS = {fault.value: fault for fault in Fault}
CHOICE = "INITIALIZE_TASK ReachRedCube STATIC_4x4"


def rows_of_page() -> list[Rule]:
    """Read the table of the documents: device, fault, when, the cell, reply, log."""
    rows = []
    for line in PAGE.read_text("utf-8").splitlines():
        cells = [cell.strip().strip("`") for cell in line.strip("|").split("|")]
        if line.startswith("| ") and len(cells) == 6 and cells[3] in DEEDS:
            device, fault, when, deed, reply, log = cells
            rows.append(Rule(device, FAULTS[fault], when, DEEDS[deed], reply, log))  # type: ignore[arg-type]
    return rows


ROWS = rows_of_page()


def matches(pattern: str, text: str) -> bool:
    """Return whether a text is what a pattern says, in which ``...`` stands for any words."""
    words = ".*".join(re.escape(part) for part in pattern.split("..."))
    return re.fullmatch(words + ("" if pattern.endswith("...") else ".*"), text) is not None


def scenario_of(rule: Rule) -> Scenario:
    return SCENARIOS[rule.device, rule.fault.value, rule.when]


def test_the_page_and_the_code_have_the_same_table() -> None:
    assert tuple(ROWS) == POLICY


def test_every_row_has_a_scenario_and_every_scenario_a_row() -> None:
    keys = [(rule.device, rule.fault.value, rule.when) for rule in ROWS]
    assert sorted(keys) == sorted(SCENARIOS)


def test_every_row_is_met_several_times() -> None:
    met = [ROWS[index % len(ROWS)] for index in range(SESSIONS)]
    assert min(met.count(rule) for rule in ROWS) >= 5


@pytest.fixture
def lines() -> Iterator[Lines]:
    handler = Lines()
    root = logging.getLogger()
    root.addHandler(handler)
    yield handler
    root.removeHandler(handler)


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_sessions_with_faults_end_as_the_table_says(chunk: int, lines: Lines) -> None:
    for index in range(chunk, SESSIONS, CHUNKS):
        rule, seed = ROWS[index % len(ROWS)], FIRST_SEED + index
        generator = random.Random(seed)
        moment = generator.choice(scenario_of(rule).moments)
        print(f"seed {seed}: {rule.device}, {rule.fault.value}, {rule.when}, in {moment}")
        lines.lines.clear()
        with deadline(seed):
            Course(rule, moment, seed, generator, lines).run()


class Course:
    """One session with one fault, and another session after it."""

    def __init__(
        self, rule: Rule, moment: Moment, seed: int, generator: random.Random, lines: Lines
    ) -> None:
        self.rule = rule
        self.moment = moment
        self.generator = generator
        self.lines = lines
        self.rig = FaultRig(seed)
        self.scenario = scenario_of(rule)
        self.fails = rule.deed in (Deed.HOLD, Deed.STOP)

    def run(self) -> None:
        talk = self.rig.session("client")
        assert talk.say(CHOICE).startswith("AVAILABLE_ACTIONS")
        self.go_to(talk)
        self.scenario.begin(self.rig, self.generator, self.moment)
        before = len(talk.replies)
        self.go_on(talk)
        self.judge(talk.replies[before:])
        self.scenario.mend(self.rig)
        if self.moment != "clean-up":
            self.take_up_again(talk)
            assert talk.say("DONE") == "GOODBYE"
        talk.end()
        self.come_again()
        assert self.rig.witness.wrong == []
        assert self.rig.witness.motions > 0
        self.rig.cell.dispose()

    def go_to(self, talk: Talk) -> None:
        """Bring the session to where the fault is to happen."""
        if self.moment == "lay-out":
            return
        assert talk.set_up() == "OK"
        if self.moment == "view":
            assert talk.say("GET_VIEW CAMERA_TOP").startswith("VIEW CAMERA_TOP")
            assert talk.say("ACTION RIGHT").startswith("REWARD")

    def go_on(self, talk: Talk) -> None:
        """Do what the fault happens in."""
        match self.moment:
            case "lay-out" | "again":
                talk.set_up()
            case "step":
                talk.say("ACTION UP")
            case "view":
                talk.say("GET_VIEW CAMERA_TOP")
            case "clean-up":
                talk.say("DONE")

    def judge(self, replies: list[str]) -> None:
        """Hold reply, log and events against the row."""
        rule, witness = self.rule, self.rig.witness
        last = replies[-1]
        if self.moment == "clean-up":
            assert last == "GOODBYE"
        elif self.fails:
            assert matches(rule.reply, last), f"{last!r} is not {rule.reply!r}"
        else:
            assert rule.reply == "-"
            assert not last.startswith("ERROR"), last
        if rule.log != "-":
            found = [line for line in self.lines.lines if matches(rule.log, line)]
            assert found, f"no line {rule.log!r} in {self.lines.lines}"
        bodies = witness.bodies
        if rule.deed is Deed.RETRY:
            assert any(isinstance(body, RequestRepeated) for body in bodies)
        if rule.deed is Deed.RECOVER:
            assert any(isinstance(body, DeviceRecovered) for body in bodies)
        if not self.fails:
            assert not any(isinstance(body, ArmHeld) for body in bodies)
        elif rule.when != "while opening":
            assert any(isinstance(body, ArmHeld) for body in bodies)

    def take_up_again(self, talk: Talk) -> None:
        """Go on in the same session, now that the cause is gone."""
        is_over = self.rule.deed is Deed.STOP
        if self.moment in ("step", "view"):
            reply = talk.say("ACTION RIGHT")
            assert reply.startswith("NO_TASK_SELECTED" if is_over else "REWARD"), reply
        if self.moment in ("lay-out", "again") or is_over:
            assert talk.say(CHOICE).startswith("AVAILABLE_ACTIONS")
            self.set_up_after_all(talk)
            assert talk.say("ACTION RIGHT").startswith("REWARD")
        if self.fails and self.rule.when != "while opening":
            clear = [b for b in self.rig.witness.bodies if isinstance(b, ResumeChecked)]
            assert clear[-1].is_clear

    def set_up_after_all(self, talk: Talk) -> None:
        """Set up; a lost block is put back by a person first, if the cell asks for that."""
        reply = talk.set_up()
        if self.rig.cell.ledger.strays():
            assert self.rule.fault is Fault.BLOCK_LOST
            assert "not found" in reply
            self.rig.put_strays_back()
            reply = talk.set_up()
        assert reply == "OK", reply

    def come_again(self) -> None:
        """Play another session, after which the ledger has every block at home, and is right."""
        rig = self.rig
        if rig.cell.ledger.open_transfer() is None:
            rig.assert_ledger_true(self.fallen())
        talk = rig.session("next client")
        assert talk.say(CHOICE).startswith("AVAILABLE_ACTIONS")
        self.set_up_after_all(talk)
        assert talk.say("ACTION UP").startswith("REWARD")
        assert talk.say("DONE") == "GOODBYE"
        talk.end()
        assert rig.cell.manipulator.is_table_clean()
        rig.assert_ledger_true(self.fallen())

    def fallen(self) -> frozenset[int]:
        """Return the blocks that lie where they fell: with that fault, any that was carried."""
        is_loose = self.rule.fault in (Fault.BLOCK_LOST, Fault.POWER_LOSS)
        return frozenset(self.rig.off_home_mm()) if is_loose else frozenset()
