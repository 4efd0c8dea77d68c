"""The page of the worm in two dimensions tells the parameters that the worm has."""

from pathlib import Path

from benchmarks.filament_worm import END, START, changed, parameter_row

from worm_model.filament.parameters import FITTED, FilamentParameters, parameter_table

PAGE = Path(__file__).parents[1] / "docs" / "filament_worm.md"


def test_every_parameter_stands_on_the_page_with_its_value():
    page = PAGE.read_text("utf-8")
    assert page.count(START) == page.count(END) == 1
    for row in parameter_table(FilamentParameters()):
        assert parameter_row(*row) in page


def test_each_fitted_parameter_is_changed_both_ways_and_no_other():
    worm = FilamentParameters()
    fitted = {name for name, _, _, _, source in parameter_table(worm) if source.startswith(FITTED)}
    variants = dict(changed(worm))
    assert len(variants) == 2 * len(fitted)
    for label, variant in variants.items():
        differ = {n for n, v, *_ in parameter_table(variant) if v != getattr(worm, n)}
        assert differ == {label.split()[0]}
        assert differ <= fitted
