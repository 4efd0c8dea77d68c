"""A cursor gives each picture and each loss once, from the beginning or from where it stopped."""

from collections import deque

from hypothesis import given
from hypothesis import strategies as st

from worm_msgs_py import SourceEventKind
from worm_tracker.sources.bags.bag_cursor import BagCursor
from worm_tracker.sources.bags.bag_reader import BagLoss, BagPicture


class Bag:
    """Pictures with so many losses before each, and after the last."""

    def __init__(self, before):
        self.before, self.losses = before, deque()

    def __iter__(self):
        for index, count in enumerate(self.before):
            self.losses += [BagLoss(SourceEventKind.LOST, f"{index}.{k}", 1) for k in range(count)]
            if index < len(self.before) - 1:
                yield BagPicture(10 * index, index, b"")


def play(cursor, sent, until):
    """Play as the replay does; return what was sent and told."""
    done = []
    while sent < until:
        done += cursor.take_losses(sent)
        if cursor.picture is None:
            break
        done.append(cursor.picture)
        sent += 1
        cursor.advance()
    return done


@given(st.lists(st.integers(0, 3), min_size=1, max_size=12), st.data())
def test_what_was_stopped_goes_on_with_the_next_picture_and_loss(before, data):
    pictures = len(before) - 1
    bag = Bag(before)
    whole = play(BagCursor(bag, bag.losses), 0, pictures + 1)
    assert [item for item in whole if isinstance(item, BagPicture)] == [
        BagPicture(10 * index, index, b"") for index in range(pictures)
    ]
    told = [item for item in whole if not isinstance(item, BagPicture)]
    assert [event.why for event in told] == [
        f"{i}.{k}" for i, n in enumerate(before) for k in range(n)
    ]
    stop = data.draw(st.integers(0, pictures))
    first, second = Bag(before), Bag(before)
    cursor = BagCursor(first, first.losses)
    began = play(cursor, 0, stop)
    again = BagCursor(second, second.losses)
    again.last_ns, again.losses_told = cursor.last_ns, cursor.losses_told
    again.go_on_after(stop)
    assert began + play(again, stop, pictures + 1) == whole


def test_an_end_asked_for_is_the_end():
    bag = Bag([0, 0, 0])
    cursor = BagCursor(bag, bag.losses)
    cursor.advance()
    cursor.end()
    assert cursor.picture is None
    cursor.advance()
    assert (cursor.picture, cursor.last_ns) == (None, 0)
