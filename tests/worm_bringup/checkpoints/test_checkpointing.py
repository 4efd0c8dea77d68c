"""Checkpoints in a run: what one took of the memory goes back before the next frame."""

from stopped_replays import replay, trial_of

from worm_bringup.checkpoints import CheckpointFolder, checkpointing
from worm_model.simulator.film import write_film
from worm_model.simulator.scenes import Take, at_the_wall


def test_what_a_checkpoint_took_is_given_back_at_once(tmp_path, monkeypatch):
    write_film(tmp_path / "film", at_the_wall(Take(px_per_mm=12.0, frames=4)))
    happened = []
    save = CheckpointFolder.save

    def saved(*args, **named):
        happened.append("saved")
        return save(*args, **named)

    monkeypatch.setattr(CheckpointFolder, "save", saved)
    monkeypatch.setattr(
        checkpointing, "give_back_freed_memory", lambda: happened.append("given back")
    )
    assert replay(trial_of(tmp_path / "film"), tmp_path / "out", interval_s=0.0) == []
    assert len(happened) >= 6
    assert happened == ["saved", "given back"] * (len(happened) // 2)
