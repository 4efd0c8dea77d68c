"""Arrays come back from a checkpoint with their strides, and views as views of one memory."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from worm_bringup.checkpoints.exact_pickle import dumps, loads

DTYPES = st.sampled_from([np.uint8, np.float32, np.float64, np.int64, bool])
ROOTS = arrays.arrays(DTYPES, arrays.array_shapes(min_dims=1, max_dims=3, max_side=6))


@st.composite
def views(draw):
    """Draw an array, in either order of memory, and a part of it, turned and cut as may be."""
    root = draw(ROOTS)
    if draw(st.booleans()):
        root = np.asfortranarray(root)
    view = root[draw(arrays.basic_indices(root.shape, allow_ellipsis=False))]
    return root, view.T if draw(st.booleans()) and isinstance(view, np.ndarray) else view


@given(views())
def test_an_array_comes_back_with_its_values_its_type_and_its_strides(drawn):
    _, view = drawn
    again = loads(dumps(view))
    assert again.dtype == view.dtype
    assert np.shape(again) == np.shape(view)
    assert again.tobytes() == view.tobytes()
    if np.size(view):
        assert again.strides == view.strides


@given(views())
def test_what_shared_memory_shares_it_again(drawn):
    root, view = drawn
    root_again, view_again = loads(dumps((root, view)))
    if isinstance(view, np.ndarray):
        assert np.shares_memory(root_again, view_again) == np.shares_memory(root, view)


def test_a_product_with_a_turned_array_rounds_alike():
    rng = np.random.default_rng(0)
    weights, rows = rng.random(101), rng.random((50, 101))
    turned = [row[::-1] for row in rows]
    products = [row @ weights for row in turned]
    assert [row @ weights for row in loads(dumps(turned))] == products
    assert [row.copy() @ weights for row in turned] != products  # what it is there for


def test_a_part_that_is_written_is_written_in_the_whole():
    whole = np.zeros((4, 6), np.float32)
    band = whole[1:3]
    whole_again, band_again = loads(dumps((whole, band)))
    band_again += 1
    assert whole_again.sum() == 12


def test_a_view_that_may_not_be_written_may_not_be_written_again():
    view = np.zeros((4, 6))[::2]
    view.flags.writeable = False
    assert not loads(dumps(view)).flags.writeable


def test_it_holds_from_pickle_to_pickle():
    whole = np.arange(24.0).reshape(4, 6)
    pair = (whole, whole[::-1, ::2])
    for _ in range(3):
        pair = loads(dumps(pair))
    assert pair[1].strides == (-48, 16)
    assert np.shares_memory(*pair)


def test_memory_that_is_not_an_arrays_own_is_copied():
    view = np.frombuffer(bytearray(b"abcdef"), np.uint8)[::2]
    assert loads(dumps(view)).tobytes() == b"ace"
