from cell.drivers.schunk_smp.tables import PROBLEMS, REGISTER_TYPES, Code, Register, problem_of


def test_every_code_has_a_text() -> None:
    assert set(PROBLEMS) == set(Code)
    assert all(problem.text for problem in PROBLEMS.values())


def test_every_error_has_an_advice() -> None:
    assert all(problem_of(code).advice for code in Code if code >= Code.TEMPERATURE_LOW)


def test_an_unknown_code_is_named_by_its_number() -> None:
    assert "0xf7" in problem_of(0xF7).text


def test_every_register_has_a_type() -> None:
    assert set(REGISTER_TYPES) == set(Register)
