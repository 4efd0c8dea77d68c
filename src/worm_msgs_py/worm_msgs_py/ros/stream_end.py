"""When a node has all that is sent to it: it finishes, once.

The source says on `flow/end` how many frames it sent; a node that has finished says on
`flow/finished` how many messages it sent on each topic (`worm_msgs_py.ros.counting_publisher`).
Either may come before the last message does, so a node asks after each whether it has everything.
"""

from collections.abc import Callable, Collection

from diagnostic_msgs.msg import DiagnosticStatus
from std_msgs.msg import UInt64

from worm_msgs_py import convert
from worm_msgs_py.errors import MalformedMessage
from worm_msgs_py.ros.counting_publisher import Announcement, read_announcement


class StreamEnd:
    """What was said to be sent to a node, how much of it was taken, and whether it has finished.

    Parameters
    ----------
    finish : callable
        The node's last results; called once.
    is_whole : callable, optional
        Whether the node has everything, asked once anything was said of the end. Otherwise it has
        when it has taken as many frames as the source has sent.
    announcers : collection of str
        Nodes whose announcements are taken.

    Attributes
    ----------
    taken : int
        Frames that the node has taken; the node counts them.
    frames : int or None
        Frames that the source has sent, once it has said so.
    announced : dict
        The announcements, by the node's name.
    done : bool
        Whether the node has finished.
    """

    def __init__(
        self,
        finish: Callable[[], None],
        is_whole: Callable[[], bool] | None = None,
        announcers: Collection[str] = (),
    ):
        self._finish = finish
        self._is_whole = is_whole or self._all_frames_taken
        self._announcers = announcers
        self.taken = 0
        self.frames: int | None = None
        self.announced: dict[str, Announcement] = {}
        self.done = False

    @property
    def missing(self) -> str:
        """Which frames are still to come, for people; empty where the node has finished."""
        if self.done:
            return ""
        frames = "?" if self.frames is None else self.frames
        return f"{self.taken} of {frames} frames have come"

    @property
    def silent(self) -> list[str]:
        """Nodes that have not announced their end."""
        return sorted(set(self._announcers) - self.announced.keys())

    def on_end(self, msg: UInt64) -> None:
        """Take how many frames the source has sent; subscribe it to `flow/end`.

        Raises
        ------
        MalformedMessage
            More frames have come, or the node has finished.
        """
        frames = convert.count_from_msg(msg)
        if frames < self.taken or self.done:
            raise MalformedMessage(f"the end after {frames} frames, where {self.taken} have come")
        self.frames = frames
        self.finish_if_whole()

    def on_announcement(self, msg: DiagnosticStatus) -> None:
        """Take what a node says as it finishes; subscribe it to `flow/finished`.

        Raises
        ------
        MalformedMessage
            It is no announcement, or of a node that is not waited for, or not any more.
        """
        said = read_announcement(msg)
        if said.name not in self.silent:
            raise MalformedMessage(f"{said.name} is not waited for")
        self.announced[said.name] = said
        self.finish_if_whole()

    def finish_if_whole(self) -> None:
        """Let the node finish if it has everything; to be asked whenever something has come."""
        if not self.done and (self.frames is not None or self.announced) and self._is_whole():
            self._finish()
            self.done = True

    def _all_frames_taken(self) -> bool:
        return self.taken == self.frames
