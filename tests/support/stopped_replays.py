"""Replays that are stopped after a frame, and what their results hold."""

import os
import signal

import pytest
from exact_content import content
from result_files import TABLES
from rosbags.rosbag2 import Reader

from worm_bringup.checkpoints import CheckpointFolder, Checkpoints
from worm_bringup.graph.node_spec import NodeSpec
from worm_bringup.overlay.viewer_messages import TYPES
from worm_bringup.provenance import bag_hash
from worm_bringup.trial import Incomplete, Trial, run_trial

FILES = (*TABLES, "summary.json", "report.html")
NEVER_S = 1e9


def trial_of(bag, tracker=None, **player):
    """Return the replay of a bag, with parameters of its tracker and of its player."""
    return Trial(
        NodeSpec("worm_tracker.sources.replay_node", "image_source", {"bag": str(bag), **player}),
        {"bag": bag.name, "sha256": bag_hash(bag), **player},
        tracker=tracker or {},
    )


def replay(trial, out, *, stop_at=None, resume=False, interval_s=NEVER_S, say=None, watch=None):
    """Run a replay, to its end or until a signal stops it after a frame; return what was said."""
    said = []
    checkpoints = Checkpoints(
        CheckpointFolder(out),
        trial.fingerprint,
        resume=resume,
        say=say or said.append,
        interval_s=interval_s,
    )

    def progress(sent, expected):
        if watch is not None:
            watch(sent)
        if sent == stop_at:
            os.kill(os.getpid(), signal.SIGINT)

    if stop_at is None:
        run_trial(trial, out, progress, checkpoints=checkpoints)
        return said
    with pytest.raises(Incomplete) as stopped:
        run_trial(trial, out, progress, checkpoints=checkpoints)
    assert stopped.value.result.interrupted
    assert stopped.value.result.frames == stop_at
    return said


def results(out):
    """Return the bytes of the files, and the content of each topic of the bag in its order.

    The bytes of a message are not its content: where CDR aligns, whatever lay in memory is sent.
    """
    found = {name: (out / name).read_bytes() for name in FILES}
    with Reader(out / "bag") as reader:
        for connection, stamp_ns, raw in reader.messages():
            message = TYPES.deserialize_cdr(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((stamp_ns, content(message)))
    return found


def differing(one, other):
    """Return the names of the files and topics that differ between two results."""
    return [name for name in {**one, **other} if one.get(name) != other.get(name)]
