"""Films of folds are drawn once, and anew where what is kept is no longer what would be drawn."""

from dataclasses import replace

import numpy as np
from benchmarks import fold_films
from benchmarks.fold_films import fold_film


def test_a_film_is_kept_with_its_truth_until_the_drawing_changes(tmp_path, monkeypatch):
    motion = fold_films._motion("4001")
    short = replace(motion, midlines_mm=motion.midlines_mm[290:303])
    monkeypatch.setattr(fold_films, "_motion", lambda name: short)
    film = fold_film("4001", "coarse", tmp_path)
    (kept,) = tmp_path.iterdir()
    drawn_at = kept.stat().st_mtime_ns
    again = fold_film("4001", "coarse", tmp_path)
    assert kept.stat().st_mtime_ns == drawn_at
    np.testing.assert_array_equal(film.picture(12), again.picture(12))

    assert len(film) == 13
    assert film.folded[0]
    assert not film.folded[-1]  # a loop that opens
    assert np.diff(film.stamp_ns).tolist() == [40_000_000] * 12
    u, v = np.rint(film.midline_px[12, 20:-20]).astype(int).T
    assert np.median(film.picture(12)[v, u]) < 80

    other = replace(short, width_mm=0.9 * short.width_mm)
    monkeypatch.setattr(fold_films, "_motion", lambda name: other)
    assert fold_film("4001", "coarse", tmp_path).width_px < film.width_px
