"""Runs `worm` commands in processes of their own without the two seconds of imports of each."""

import multiprocessing
import os
import sys

PROCESSES = multiprocessing.get_context("forkserver")
PROCESSES.set_forkserver_preload(["worm_bringup.cli.app"])


def run_command(words, folder, environment):
    """Run a command as the script `worm` does; return its exit status and what it printed."""
    said = folder / ".said"
    process = PROCESSES.Process(target=_run, args=(words, folder, environment, said))
    process.start()
    process.join()
    text = said.read_text(encoding="utf-8")
    said.unlink()
    return process.exitcode, text


def _run(words, folder, environment, said):
    from worm_bringup.cli.app import main

    os.chdir(folder)
    os.environ.update(environment)
    with said.open("wb") as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)
    sys.argv = ["worm", *words]
    main()
