"""What the documents show is run: scripts, programs, commands, names and links."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from cell.assembly import assemble_twin
from cell.clock import SimulatedClock
from cell.profile import parse_profile, profile_text
from console.cli import command_line
from dsl.compiler import compile_script
from sessions.hosting import host_twin, store_plan
from sessions.script_source import served_script
from sessions.server import Listener, MasServer

ROOT = Path(__file__).parents[1]
PAGES = sorted(ROOT.glob("*.md")) + sorted((ROOT / "docs").rglob("*.md"))


def blocks(page: Path, language: str) -> list[str]:
    text = page.read_text("utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)


def readme_script() -> str:
    (script,) = blocks(ROOT / "README.md", "cell")
    return script


def test_the_script_of_the_readme_compiles_without_a_word() -> None:
    compiled = compile_script(readme_script(), "README.md")
    assert compiled.diagnostics == ()


def test_the_program_of_the_readme_drives_the_script_of_the_readme(
    capsys: pytest.CaptureFixture[str],
) -> None:
    (program,) = blocks(ROOT / "README.md", "python")
    text = profile_text("mash")
    hosted = host_twin(
        served_script(readme_script(), "readme.cell"),
        parse_profile(text, "mash"),
        text,
        seed=1,
        clock=SimulatedClock(),
    )
    try:
        with MasServer(hosted.desk, [Listener("127.0.0.1", 0, "1.5")]) as server:
            port = server.addresses[0].port
            exec(compile(program.replace("10993", str(port)), "README.md", "exec"), {})  # noqa: S102
    finally:
        hosted.close()
    assert capsys.readouterr().out.split() == ["0.0", "640"]


def commands() -> list[tuple[str, str]]:
    found = []
    for page in PAGES:
        for block in blocks(page, "sh"):
            for line in block.splitlines():
                call = line.partition("#")[0].strip()
                if call.startswith(".venv/bin/cell "):
                    found.append((page.name, call.removeprefix(".venv/bin/cell ")))
    return found


@pytest.mark.parametrize(("page", "call"), commands())
def test_a_command_of_the_documents_is_one_that_the_program_has(page: str, call: str) -> None:
    command_line().parse_args(shlex.split(call), exit_on_error=False, print_error=False)


def test_the_documents_show_commands() -> None:
    assert len(commands()) >= 8


def test_every_old_operation_has_the_counterpart_that_the_guide_names() -> None:
    guide = (ROOT / "docs" / "howto" / "old-operations.md").read_text("utf-8")
    names = re.findall(r"`cell\.([a-z_.]+)\(", guide)
    assert len(names) >= 30
    text = profile_text("mash")
    cell = assemble_twin(
        parse_profile(text, "mash"),
        store_plan(served_script(readme_script(), "readme.cell")),
        seed=1,
        clock=SimulatedClock(),
    )
    for name in names:
        found: object = cell
        for part in name.split("."):
            found = getattr(found, part)
        assert callable(found), name
    cell.dispose()


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_links_of_a_page_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text("utf-8")):
        if "://" not in target:
            assert (page.parent / target).exists(), f"{page.name}: {target}"
