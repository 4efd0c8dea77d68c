"""Tells one publisher's messages from others', by the numbers that DDS gives them."""


class PublisherSequence:
    """Whose number is the next one of the publisher that is followed.

    The first message says where its publisher is. One that is followed from its first message is
    never left; one that was joined later is left for a publisher that begins.
    """

    def __init__(self) -> None:
        self._first: int | None = None
        self._next = 0
        self._last = 0  # beyond next by those that were malformed, and may have been ours

    def is_next(self, number: int) -> bool:
        """Whether a message of this number may be taken."""
        if self._first is None or (number == 1 and self._first != 1):
            return True
        return self._next <= number <= self._last

    def taken(self, number: int) -> None:
        """Go on to the next one."""
        if self._first is None or (number == 1 and self._first != 1):
            self._first = number
        self._next = self._last = number + 1

    def refused(self, number: int) -> None:
        """Wait for this number still, but also for the one after it: whose it was is not known."""
        if self._first is not None and number == self._last:
            self._last = number + 1
