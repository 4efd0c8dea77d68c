"""What people correct is kept as they said it, and never half, twice or in another's file."""

import json
from dataclasses import asdict, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_msgs_py.errors import BadInput
from worm_msgs_py.files.corrections import (
    CORRECTIONS_FILE,
    Correction,
    CorrectionKind,
    corrections_from_json,
    corrections_in_words,
    corrections_to_json,
    kept_corrections,
    read_corrections,
    why_not_together,
    write_corrections,
)

SWAP = Correction(
    CorrectionKind.SWAP_HEAD, 10, 1000, 20, 2000, "Mia", "2026-03-21T09:30:00Z", "the curl"
)


def swap(first, last):
    last_ns = None if last is None else 100 * last
    return replace(
        SWAP, first_frame=first, first_stamp_ns=100 * first, last_frame=last, last_stamp_ns=last_ns
    )


def request(after):
    told = swap(after, None)
    return replace(told, what=CorrectionKind.SWAP_REQUEST, by="~/swap_head", note="")


words = st.text(st.characters(categories=("L", "N", "P", "Zs")), max_size=20)
frames = st.integers(0, 2**62)
some = st.one_of(
    st.builds(request, st.integers(0, 2**50)),
    st.tuples(frames, frames, words, words).map(
        lambda told: replace(
            SWAP,
            first_frame=min(told[:2]),
            last_frame=max(told[:2]),
            by="x" + told[2],
            note=told[3],
        )
    ),
)


@given(st.lists(some, max_size=5))
def test_corrections_come_back_as_they_were_said_or_are_refused(told):
    text = corrections_to_json(told)
    if why_not_together(told):
        with pytest.raises(BadInput, match="exchanged twice"):
            corrections_from_json(text)
    else:
        assert corrections_from_json(text) == tuple(told)


@given(st.lists(st.tuples(st.integers(0, 12), st.integers(0, 5) | st.none()), max_size=4))
def test_no_frame_is_exchanged_twice(ranges):
    told = [swap(first, None if more is None else first + more) for first, more in ranges]
    most = max((sum(each.swaps(frame) for each in told) for frame in range(20)), default=0)
    assert bool(why_not_together(told)) == (most > 1)


def test_a_request_may_be_made_twice_and_beside_a_swap():
    assert why_not_together([request(5), request(5), swap(0, None)]) == ""
    assert not any(request(5).swaps(frame) for frame in range(10))


def test_a_file_and_its_directory_are_read_alike_and_none_is_no_correction(tmp_path):
    assert kept_corrections(tmp_path) == ()
    write_corrections(tmp_path / CORRECTIONS_FILE, [SWAP, request(3)])
    assert read_corrections(tmp_path) == read_corrections(tmp_path / CORRECTIONS_FILE)
    assert kept_corrections(tmp_path) == (SWAP, request(3))
    assert [item.name for item in tmp_path.iterdir()] == [CORRECTIONS_FILE]


def test_what_is_there_is_replaced_only_where_it_is_ours(tmp_path):
    path = tmp_path / CORRECTIONS_FILE
    write_corrections(path, [SWAP])
    write_corrections(path, [])
    assert read_corrections(path) == ()
    path.write_text("my notes")
    with pytest.raises(BadInput, match=r"corrections\.json: is no file of corrections"):
        write_corrections(path, [SWAP])
    assert path.read_text() == "my notes"


def test_swaps_of_one_frame_are_not_written(tmp_path):
    path = tmp_path / CORRECTIONS_FILE
    write_corrections(path, [SWAP])
    with pytest.raises(BadInput, match="exchanged twice in frame 20"):
        write_corrections(path, [SWAP, swap(20, None)])
    assert read_corrections(path) == (SWAP,)


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ({"what": "turn"}, "says 'turn': give swap_head or swap_request"),
        ({"first_frame": -1}, "first_frame -1"),
        ({"first_frame": True}, "first_frame True"),
        ({"first_stamp_ns": 1.5}, "first_stamp_ns 1.5"),
        ({"first_frame": None}, "first_frame None"),
        ({"last_frame": 9}, "ends with frame 9, before its first"),
        ({"last_frame": None}, "give both, or null for both"),
        ({"what": "swap_request"}, "a request with a last frame"),
        ({"by": ""}, "who made it"),
        ({"by": 5}, "by that is no text"),
        ({"note": "x" * 401}, "note that is no text of 400"),
        ({"note": "\x1b[2J"}, "cannot be printed"),
        ({"at": "2026-03-21T09:30:00"}, "give a time"),
        ({"at": "2026-03-21T09:30:00+01:00"}, "give a time"),
        ({"at": 7}, "give a time"),
        ({"head": 1}, "has 'head', which no correction has"),
    ],
)
def test_what_is_wrong_with_a_correction_is_said_in_a_line(tmp_path, changed, why):
    path = tmp_path / CORRECTIONS_FILE
    entry = asdict(SWAP) | changed
    path.write_text(json.dumps({"format": 1, "corrections": [asdict(swap(0, 3)), entry]}))
    with pytest.raises(BadInput) as refused:
        read_corrections(path)
    said = str(refused.value)
    assert why in said
    assert "correction 2" in said
    assert said.startswith(f"{path}: ")
    assert "\n" not in said


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"corrections": []}', '{"format": 2, "corrections": []}', "[" * 99999]
)
def test_what_is_no_file_of_corrections_is_refused(tmp_path, text):
    path = tmp_path / CORRECTIONS_FILE
    path.write_text(text)
    with pytest.raises(BadInput, match="is no file of corrections"):
        read_corrections(path)


def test_a_line_for_people_says_which_frames_and_by_whom_and_stays_a_line():
    by_hand, on_request = corrections_in_words([swap(1, 1), request(5), swap(3, None)], 12)
    assert by_hand == (
        "head and tail were exchanged by hand in 12 frames: from frame 1 to 1 (by Mia); "
        "from frame 3 to the end (by Mia)"
    )
    assert on_request == "head and tail were exchanged on request: after frame 5 (by ~/swap_head)"
    (long,) = corrections_in_words([swap(n, n) for n in range(1000)], 1000)
    assert long.endswith("from frame 4 to 4 (by Mia); and 995 more, in corrections.json")
    assert corrections_in_words([], 0) == []


def test_a_file_that_is_not_there_says_what_makes_it(tmp_path):
    with pytest.raises(BadInput, match="is not there: give a corr"):
        read_corrections(tmp_path)
