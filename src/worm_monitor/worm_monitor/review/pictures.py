"""Where the pictures of a trial are, and each of them as a browser shows it."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from worm_monitor.pictures import shown_jpeg
from worm_monitor.review.trial import ReviewedTrial
from worm_msgs_py.errors import BadInput, BadPicture
from worm_msgs_py.files.frame_pictures import frame_pictures
from worm_tracker.sources.bags.bag_reader import BagPictures
from worm_tracker.sources.bags.one_picture import open_bag_of, picture_at
from worm_tracker.sources.image_decoder import Grey

_NOT_FOUND = "the bag is not found: name it with --bag"
_OF_A_TABLE = "these results were made of a table of tracks, which came without pictures"
_BLANK = 40
"""Grey level of the ground that is drawn on where there is no picture."""


class TrialPictures:
    """The pictures of a trial's frames.

    Parameters
    ----------
    trial : ReviewedTrial
    bag : Path or None
        What holds them; None where no bag is found.

    Raises
    ------
    BadInput
        The bag is none, or is another one's.
    """

    def __init__(self, trial: ReviewedTrial, bag: Path | None) -> None:
        self.trial = trial
        self.bag = bag
        self._open: BagPictures | None = None
        if bag is None:
            return
        self._open = open_bag_of(bag, self._played, 0.0, None)
        try:
            for row in self._looked_for():
                with suppress(BadPicture):  # it is the right one, and damaged
                    self._of_bag(self._open, row)
        except BadInput as error:
            self.close()
            raise BadInput(f"{bag}: is not the bag of {trial.directory}: {error}") from None
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Let go of the bag."""
        if self._open is not None:
            self._open.close()

    def jpeg(self, row: int) -> tuple[bytes, float, str]:
        """Return a frame's picture, how much smaller it was made, and why it is blank.

        The last is empty where it is not blank.
        """
        why = _OF_A_TABLE if self.trial.of_table else _NOT_FOUND
        try:
            grey = self._kept(row) if self._open is None else self._of_bag(self._open, row)
        except (BadInput, BadPicture, OSError) as error:
            grey, why = None, str(error)
        if grey is not None:
            return *shown_jpeg(grey), ""
        width, height = self.trial.size_px
        return *shown_jpeg(np.full((height, width), _BLANK, dtype=np.uint8)), why

    def _looked_for(self) -> tuple[int, ...]:
        """Return the frames that a bag must have to be the right one.

        A bag that was replayed has all; other films may begin at the same moment, such as zero.
        What a live trial recorded may end before it, where the disk was full.
        """
        last = len(self.trial.frames) - 1
        was_replayed = "sha256" in self.trial.results.provenance["source"]
        return (0, last // 2, last) if was_replayed else (0,)

    @property
    def _played(self) -> dict[str, Any]:
        """What of the source's parameters tells where its pictures are."""
        source = self.trial.results.provenance["source"]
        return {name: source.get(name) for name in ("bag", "topic")} | {
            "salvage": "salvaged" in source
        }

    def _of_bag(self, bag: BagPictures, row: int) -> Grey:
        results = self.trial.results
        offset_s = float(results.provenance["source"].get("start_offset_s") or 0.0)
        after_s = offset_s + float(results.t_s[row])
        return picture_at(bag.part, int(self.trial.stamps_ns[row]), after_s)

    def _kept(self, row: int) -> Grey | None:
        """Return the picture that the report opens with, if it is of this frame."""
        path = frame_pictures(self.trial.directory).get(int(self.trial.frames[row]))
        grey = None if path is None else cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        return None if grey is None else np.asarray(grey, dtype=np.uint8)


def find_pictures(trial: ReviewedTrial, bag: Path | None) -> TrialPictures:
    """Return the pictures: of the bag that is given, or of the one that the results name.

    That is looked for where the command runs and around the results, also in a folder `bags`; at
    last the results' own bag may hold pictures. A bag counts if it has the stamps.

    Raises
    ------
    BadInput
        The bag that is given is none, or another one's.
    """
    if bag is not None:
        return TrialPictures(trial, bag)
    for place in _places_of_bags(trial):
        with suppress(BadInput, OSError):
            return TrialPictures(trial, place)
    return TrialPictures(trial, None)


def _places_of_bags(trial: ReviewedTrial) -> Iterator[Path]:
    name = trial.results.provenance["source"].get("bag")
    if name and Path(name).name == name:
        around = (Path(), *trial.directory.absolute().parents[:2])
        for folder in dict.fromkeys(p / more for p in around for more in ("", "bags")):
            if (folder / name).exists():
                yield folder / name
    yield trial.directory / "bag"
