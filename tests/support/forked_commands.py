"""Runs `worm` commands in processes of their own without the five seconds of imports of each.

A process that has all imported that a replay needs, and nothing else, is forked for each command.
The script `worm` itself, from its first import to its last byte, is run by tests of how a process
starts and ends (signals, working directories), and by the main job on the larva.
"""

import multiprocessing
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from worm_bringup.graph.nodes import NODES

PROCESSES = multiprocessing.get_context("forkserver")
PROCESSES.set_forkserver_preload(
    [
        "worm_bringup.cli.app",
        *(NODES[node] for node in ("replay", "camera", "tracker", "analysis", "model", "recorder")),
        "worm_analysis.report.panels",
        "matplotlib.backends.backend_pdf",
    ]
)


def worm(*words, cwd=None, env=None):
    """Run a command as the script `worm` does; return what `subprocess.run` returns of it."""
    with tempfile.TemporaryDirectory() as folder:
        said = [Path(folder) / stream for stream in ("stdout", "stderr")]
        words = [str(word) for word in words]
        given = (words, cwd or Path.cwd(), dict(os.environ if env is None else env), said)
        process = PROCESSES.Process(target=_run, args=given)
        process.start()
        process.join()
        texts = [file.read_text(encoding="utf-8") for file in said]
    return subprocess.CompletedProcess(words, process.exitcode, *texts)


def run_command(words, folder, environment):
    """Run a command as the script `worm` does; return its exit status and what it printed."""
    said = folder / ".said"
    given = (words, folder, os.environ | environment, [said, said])
    process = PROCESSES.Process(target=_run, args=given)
    process.start()
    process.join()
    text = said.read_text(encoding="utf-8")
    said.unlink()
    return process.exitcode, text


def _run(words, folder, environment, said):
    from worm_bringup.cli.app import main

    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    for stream, file in enumerate(said, start=1):
        # What both write to one file stands in it in its order.
        written = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.dup2(written, stream)
        os.close(written)
    sys.argv = ["worm", *words]
    main()
