import pytest

from cell.drivers.schunk_smp.crc import crc16


def test_the_checksum_has_the_check_value_of_crc_16_arc() -> None:
    assert crc16(b"123456789") == 0xBB3D


def test_the_checksum_of_nothing_is_zero_and_so_not_that_of_modbus() -> None:
    assert crc16(b"") == 0x0000


@pytest.mark.parametrize("bit", range(40))
def test_every_single_wrong_bit_changes_the_checksum(bit: int) -> None:
    good = bytearray.fromhex("050C0192FF")
    wrong = bytearray(good)
    wrong[bit // 8] ^= 1 << bit % 8
    assert crc16(wrong) != crc16(good)


def test_a_message_with_its_checksum_behind_it_has_checksum_zero() -> None:
    assert crc16(bytes.fromhex("07 01 07 95 36 89 81 3F 02 00 F9 BC")) == 0
