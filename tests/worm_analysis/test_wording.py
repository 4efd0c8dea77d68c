"""One item is in the singular."""

import pytest

from worm_analysis.wording import items_in_words


@pytest.mark.parametrize(
    ("items", "one"),
    [
        ("searches", "search"),
        ("visits", "visit"),
        ("failed attempts", "failed attempt"),
        ("findings of the exit after a contact", "finding of the exit after a contact"),
        ("quantities that the walk predicts", "quantity that the walk predicts"),
        ("moments, 0.1 s apart", "moment, 0.1 s apart"),
        ("complete contacts above the limit", "complete contact above the limit"),
    ],
)  # fmt: skip
def test_one_item_is_in_the_singular(items, one):
    assert items_in_words(1, items) == one
    assert items_in_words(0, items) == items_in_words(2, items) == items
