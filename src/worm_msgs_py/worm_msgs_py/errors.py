"""Errors that a user can do something about, each one line with its remedy."""


class BadInput(ValueError):  # noqa: N818 (it is the input that is bad)
    """The input cannot be used: no such bag, not a bag, an encoding that is not read, ..."""


class BadPicture(ValueError):  # noqa: N818
    """One picture is damaged; those before and after it may be whole."""


class MalformedMessage(ValueError):  # noqa: N818 (it is the message that is bad)
    """A message on a topic of the graph is not one of its messages; it is counted and ignored."""


class NotAPicture(BadInput, TypeError):  # noqa: N818
    """What was given as a picture is none: grey levels of eight bits in two dimensions are."""


class TrackerError(BadInput):
    """The tracker cannot go on with what it was given."""


class NoChamberFound(TrackerError):  # noqa: N818 (the name is part of the tracker's interface)
    """No circular chamber stands out in the first pictures."""


class ReportError(ValueError):
    """The results cannot be reported; the message names the file, the cause and the remedy."""


class EvaluationError(ValueError):
    """A table cannot be evaluated: one line that names it, the cause and the remedy."""


class NodeFailed(RuntimeError):  # noqa: N818
    """A node of the graph failed or hangs; its traceback is on stderr."""


BAD_INPUT, INCOMPLETE = 2, 1
"""Exit statuses of all programs: what was given cannot be used; the results are not whole."""
RUN_AGAIN = "run `worm replay` or `worm analyse` again"
"""The remedy for results that cannot be read."""
