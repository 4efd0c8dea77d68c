"""Text that others wrote, made safe to print: file names, topics, labels, messages of libraries."""

from unicodedata import category


def printable(text: object) -> str:
    r"""Return text on one line in which nothing acts on a terminal.

    Control characters, line ends, escapes such as ``\x1b[2J``, marks that turn the direction of
    writing and bytes that are no UTF-8 come out as Python writes them, ``\x1b``; all else as it is.

    Parameters
    ----------
    text : object
        Taken by its `str`.
    """
    return "".join(
        sign
        if sign.isprintable() or category(sign) == "Zs"
        else sign.encode("unicode_escape").decode("ascii")
        for sign in str(text)
    )
