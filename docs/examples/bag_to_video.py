"""Make a video of a bag's pictures.

python docs/examples/bag_to_video.py BAG VIDEO.avi
"""

import sys
from itertools import chain, islice
from pathlib import Path

import cv2

from worm_tracker.sources.bags.pictures import pictures_of_bag


def main(bag: str, video: str) -> None:
    """Write every picture that can be read, at the rate of the first two."""
    pictures = ((grey, stamp_ns) for grey, stamp_ns in pictures_of_bag(bag) if grey.size)
    first = list(islice(pictures, 2))
    rate_hz = 1e9 / (first[1][1] - first[0][1])
    height, width = first[0][0].shape
    Path(video).parent.mkdir(parents=True, exist_ok=True)
    codec = cv2.VideoWriter.fourcc(*"MJPG")
    film = cv2.VideoWriter(video, codec, rate_hz, (width, height), isColor=False)
    for grey, _ in chain(first, pictures):
        film.write(grey)
    film.release()


if __name__ == "__main__":
    main(*sys.argv[1:])
