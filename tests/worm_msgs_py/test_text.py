"""What is printed of others' text never acts on a terminal."""

from unicodedata import category

import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_msgs_py.text import printable

ANY_TEXT = st.text(st.characters(categories=("L", "N", "P", "S", "Z", "C")))


@given(ANY_TEXT)
def test_every_text_comes_out_on_one_line_without_a_control_character(text: str) -> None:
    shown = printable(text)
    assert not {category(sign) for sign in shown} & {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}
    shown.encode("utf-8")
    assert len(shown.splitlines()) <= 1


@given(ANY_TEXT.filter(str.isprintable))
def test_text_that_can_be_printed_is_left_alone(text: str) -> None:
    assert printable(text) == text


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("/image\x1b[2J", r"/image\x1b[2J"),
        ("one\ntwo", r"one\ntwo"),
        ("a\u202eb", r"a\u202eb"),
        ("bag\udcff", r"bag\udcff"),
        ("ψ_b −40° …", "ψ_b −40° …"),
    ],
)
def test_what_acts_is_shown_as_python_writes_it(text: str, shown: str) -> None:
    assert printable(text) == shown
