"""Tells the topic of messages that nothing describes any more by what they look like."""

from dataclasses import replace

from worm_tracker.sources.bags.scan.scan_result import Topic
from worm_tracker.sources.bags.serialized_images import read_picture
from worm_tracker.sources.image_decoder import COMPRESSED_TYPE, IMAGE_TYPE


def guessed_topic(number: int, data: bytes, named: Topic | None = None) -> Topic | None:
    """Return a topic of pictures, named after its number; None where the data is no picture.

    Parameters
    ----------
    named : Topic, optional
        What is known of it; only its type is missing.
    """
    for kind in (COMPRESSED_TYPE, IMAGE_TYPE):
        try:
            read_picture(data, kind)
        except ValueError:
            continue
        return Topic(f"/recovered_{number}", kind) if named is None else replace(named, type=kind)
    return named
