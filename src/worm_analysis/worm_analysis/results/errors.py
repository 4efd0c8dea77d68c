"""What can be wrong with a results directory."""


class ReportError(ValueError):
    """The results cannot be reported; the message names the file, the cause and the remedy."""


REMEDY = "run `worm replay` or `worm analyse` again"
