"""What a scan of a storage file finds: messages, and places that cannot be read."""

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic as the file describes it.

    Attributes
    ----------
    name, type : str
        Such as ``/image_raw`` and ``sensor_msgs/msg/Image``.
    serialization : str
        Such as ``cdr``.
    definition, definition_format : str
        The type's definition and its format (``ros2msg``); empty where the file has none.
    metadata : dict
        What a recorder noted of it, such as QoS; it plays no part in comparisons.
    """

    name: str
    type: str
    serialization: str = "cdr"
    definition: str = ""
    definition_format: str = ""
    metadata: dict[str, str] = field(default_factory=dict, compare=False)


@dataclass(frozen=True, slots=True)
class FoundMessage:
    """One message.

    Attributes
    ----------
    topic : Topic
        Where it was sent.
    log_ns, publish_ns : int
        Times of recording and of sending, as they stand in the file.
    sequence : int
        Its number on the topic, 0 where the recorder counts nothing.
    data : bytes
        The serialised message.
    """

    topic: Topic
    log_ns: int
    publish_ns: int
    sequence: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Lost:
    """A place that cannot be read.

    Attributes
    ----------
    why : str
        What is wrong there, where, and what became of it; never empty.
    messages : int or None
        How many messages were there; None where nobody knows, 0 where none is missing (the place
        was read, but a checksum says that it is not what was written).
    size : int
        Bytes that were passed over.
    """

    why: str
    messages: int | None
    size: int = 0


Found = FoundMessage | Lost
