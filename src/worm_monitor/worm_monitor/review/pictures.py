"""Where the pictures of a trial are, and each of them as a browser shows it."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from worm_monitor.pictures import shown_jpeg
from worm_monitor.review.trial import ReviewedTrial
from worm_msgs_py.errors import BadInput, BadPicture
from worm_msgs_py.files.frame_pictures import frame_pictures
from worm_tracker.sources.bags.one_picture import open_bag_of, picture_at
from worm_tracker.sources.image_decoder import Grey

_BLANK = 40
"""Grey level of the ground that is drawn on where there is no picture."""


@dataclass(frozen=True, eq=False)
class TrialPictures:
    """The pictures of a trial's frames.

    Attributes
    ----------
    trial : ReviewedTrial
    bag : Path or None
        What holds them; None where no bag is found.
    """

    trial: ReviewedTrial
    bag: Path | None

    def jpeg(self, row: int) -> tuple[bytes, float, str]:
        """Return a frame's picture, how much smaller it was made, and why it is blank.

        The last is empty where it is not blank.
        """
        why = "the bag is not found: name it with --bag"
        try:
            grey = self._kept(row) if self.bag is None else self._of_bag(self.bag, row)
        except (BadInput, BadPicture, OSError) as error:
            grey, why = None, str(error)
        if grey is not None:
            return *shown_jpeg(grey), ""
        width, height = self.trial.size_px
        return *shown_jpeg(np.full((height, width), _BLANK, dtype=np.uint8)), why

    def check(self) -> None:
        """Raise BadInput where the bag has no picture with the stamp of the first frame."""
        if self.bag is not None:
            self._of_bag(self.bag, 0)

    def _of_bag(self, bag: Path, row: int) -> Grey:
        results = self.trial.results
        source = results.provenance["source"]
        played = {name: source.get(name) for name in ("bag", "topic")}
        return picture_at(
            partial(open_bag_of, bag, played | {"salvage": "salvaged" in source}),
            int(self.trial.stamps_ns[row]),
            float(source.get("start_offset_s") or 0.0) + float(results.t_s[row]),
        )

    def _kept(self, row: int) -> Grey | None:
        """Return the picture that the report opens with, if it is of this frame."""
        path = frame_pictures(self.trial.directory).get(int(self.trial.frames[row]))
        grey = None if path is None else cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        return None if grey is None else np.asarray(grey, dtype=np.uint8)


def find_pictures(trial: ReviewedTrial, bag: Path | None) -> TrialPictures:
    """Return the pictures: of the bag that is given, or of the one that the results name.

    That is looked for where the command runs and around the results, also in a folder `bags`; at
    last the results' own bag may hold pictures. A bag counts if it has one with the first stamp.

    Raises
    ------
    BadInput
        The bag that is given is none, or another one's.
    """
    if bag is not None:
        given = TrialPictures(trial, bag)
        try:
            given.check()
        except BadPicture:
            pass  # damaged, and the right one
        except BadInput as error:
            if not bag.exists():
                raise
            raise BadInput(f"{bag}: is not the bag of {trial.directory}: {error}") from None
        return given
    for place in _places(trial):
        found = TrialPictures(trial, place)
        try:
            found.check()
        except (BadInput, OSError):
            continue
        except BadPicture:
            pass
        return found
    return TrialPictures(trial, None)


def _places(trial: ReviewedTrial) -> Iterator[Path]:
    name = trial.results.provenance["source"].get("bag")
    if name and Path(name).name == name:
        around = (Path(), *trial.directory.absolute().parents[:2])
        for folder in dict.fromkeys(p / more for p in around for more in ("", "bags")):
            if (folder / name).exists():
                yield folder / name
    yield trial.directory / "bag"
