"""Puts what the nodes send together again, frame by frame, and writes the results' files.

State, midline and observables of a frame come on three topics and in any order; a row is written
when all three are there, in the order of the frames. Nothing here depends on the time of arrival.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from worm_analysis.results import contacts, passages, tracks
from worm_analysis.results.parquet_table import TableWriter
from worm_analysis.results.summary import TrialRecord, build_summary, write_summary
from worm_analysis.results.sums import write_sums
from worm_msgs_py import BodyState, Episode, Event, Midline, Observables
from worm_msgs_py.files.corrections import CORRECTIONS_FILE, write_corrections


class Recording:
    """The tables and the summary of one trial, growing as messages come.

    Parameters
    ----------
    directory : Path
        Where the files are written; it exists and is empty.
    """

    def __init__(self, directory: Path):
        self._directory = directory
        self._tracks = TableWriter(directory / "tracks.parquet", tracks.SCHEMA)
        self._contacts = TableWriter(directory / "contacts.parquet", contacts.SCHEMA)
        self._passages = TableWriter(directory / "passages.parquet", passages.SCHEMA)
        self._states: dict[int, BodyState] = {}
        self._midlines: dict[int, Midline] = {}
        self._observables: dict[int, Observables] = {}
        self._statuses: Counter[str] = Counter()
        self._midlines_in = 0
        self.rows = 0
        self.trial = TrialRecord()

    def add_state(self, state: BodyState) -> None:
        """Take a frame's state."""
        self._states[state.frame] = state
        self._write_whole_frames()

    def add_midline(self, midline: Midline) -> None:
        """Take the next frame's midline: the topic is in order and has one for every frame."""
        self._midlines[self._midlines_in] = midline
        self._midlines_in += 1
        self._write_whole_frames()

    def add_observables(self, observables: Observables) -> None:
        """Take a frame's observables."""
        self._observables[observables.frame] = observables
        self._write_whole_frames()

    def add_events(self, events: Sequence[Event]) -> None:
        """Take episodes, visits and attempts in the order in which they closed."""
        for event in events:
            if isinstance(event, Episode):
                self._contacts.append(contacts.contact_row(event))
            else:
                self._passages.append(passages.passage_row(event))

    def finish(self, provenance: Mapping[str, Any]) -> None:
        """Close the tables and write the summary.

        Raises
        ------
        RuntimeError
            Where a frame was read that has no row: results that look whole must be whole.
        """
        self.close()
        if self.rows != self.trial.frames_read:
            raise RuntimeError(
                f"{self.trial.frames_read} frames were read but {self.rows} have a row"
            )
        self.trial.statuses = dict(self._statuses)
        if self.trial.corrections:
            write_corrections(self._directory / CORRECTIONS_FILE, self.trial.corrections)
        write_sums(self._directory / "sums.parquet", self.trial.sums)
        write_summary(self._directory / "summary.json", build_summary(self.trial, provenance))

    @property
    def waiting(self) -> bool:
        """Whether rows are not on the disk because it is full."""
        return any(table.waiting for table in (self._tracks, self._contacts, self._passages))

    def commit(self) -> None:
        """Put what waits onto the disk; OSError where it does not fit."""
        for table in (self._tracks, self._contacts, self._passages):
            table.commit()

    def close(self) -> None:
        """Close the tables, whole or not."""
        for table in (self._tracks, self._contacts, self._passages):
            table.close()

    def _write_whole_frames(self) -> None:
        frame = self.rows
        if frame in self._states and frame in self._midlines and frame in self._observables:
            state = self._states.pop(frame)
            midline = self._midlines.pop(frame)
            row = tracks.track_row(state, midline, self._observables.pop(frame))
            swapped = any(told.swaps(frame) for told in self.trial.corrections)
            self.trial.frames_swapped += swapped and midline.u_px.size > 0
            self._tracks.append(row)
            self._statuses[state.status.label] += 1
            self.rows += 1
            self._write_whole_frames()
