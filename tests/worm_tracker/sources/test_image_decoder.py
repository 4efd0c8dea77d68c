"""What the decoder makes of every encoding that it reads, and what it says of the others."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sensor_msgs.msg import CompressedImage, Image

from worm_msgs_py.errors import BadInput, BadPicture
from worm_tracker.sources.image_decoder import PictureDecoder


def message(picture, encoding, padding=0, big_endian=False):
    """An Image whose rows are followed by `padding` bytes that are no pixels."""
    if picture.dtype == np.uint16:
        picture = picture.astype(">u2" if big_endian else "<u2")
    rows = np.ascontiguousarray(picture).view(np.uint8).reshape(picture.shape[0], -1)
    rows = np.pad(rows, ((0, 0), (0, padding)), constant_values=171)
    result = Image(
        height=picture.shape[0],
        width=picture.shape[1],
        encoding=encoding,
        is_bigendian=int(big_endian),
        step=rows.shape[1],
    )
    result.data.frombytes(rows.tobytes())
    return result


def compressed(picture, extension, form):
    done, data = cv2.imencode(extension, picture)
    assert done
    return CompressedImage(format=form, data=data.tobytes())


sizes = st.tuples(st.integers(1, 12), st.integers(1, 12))
paddings = st.integers(0, 9)
seeds = st.integers(0, 2**32 - 1)


@given(sizes, paddings, seeds)
def test_mono8_is_read_pixel_for_pixel_whatever_its_step(size, padding, seed):
    picture = np.random.default_rng(seed).integers(0, 256, size, np.uint8)
    decoded = PictureDecoder().decode(message(picture, "mono8", padding))
    np.testing.assert_array_equal(decoded, picture)


@given(sizes, paddings, seeds)
def test_the_order_of_channels_is_told_by_the_encoding(size, padding, seed):
    bgr = np.random.default_rng(seed).integers(0, 256, (*size, 3), np.uint8)
    as_bgr = PictureDecoder().decode(message(bgr, "bgr8", padding))
    as_rgb = PictureDecoder().decode(message(bgr[..., ::-1], "rgb8", padding))
    np.testing.assert_array_equal(as_bgr, as_rgb)
    weighed = bgr @ [0.114, 0.587, 0.299]
    np.testing.assert_allclose(as_bgr, weighed, atol=0.51)


@given(sizes, paddings, seeds, st.sampled_from([8, 10, 12, 14, 16]), st.booleans())
def test_the_highest_bits_of_mono16_are_kept(size, padding, seed, bits, big_endian):
    deep = np.random.default_rng(seed).integers(0, 2**bits, size, np.uint16)
    deep[0, 0] = 2**bits - 1
    decoder = PictureDecoder()
    decoded = decoder.decode(message(deep, "mono16", padding, big_endian))
    assert decoder.significant_bits == bits
    np.testing.assert_array_equal(decoded, deep >> (bits - 8))


def test_the_depth_of_mono16_is_decided_once():
    decoder = PictureDecoder()
    black = np.zeros((2, 3), np.uint16)
    assert not decoder.decode(message(black, "mono16")).any()
    assert decoder.significant_bits is None
    decoder.decode(message(np.full((2, 3), 4000, np.uint16), "mono16"))
    assert decoder.significant_bits == 12
    dim = decoder.decode(message(np.full((2, 3), 160, np.uint16), "mono16"))
    np.testing.assert_array_equal(dim, 10)
    bright = decoder.decode(message(np.full((2, 3), 60_000, np.uint16), "mono16"))
    np.testing.assert_array_equal(bright, 255)


@given(sizes, seeds)
def test_png_loses_nothing(size, seed):
    picture = np.random.default_rng(seed).integers(0, 256, size, np.uint8)
    decoded = PictureDecoder().decode(compressed(picture, ".png", "mono8; png compressed "))
    np.testing.assert_array_equal(decoded, picture)


def test_a_deep_png_is_read_like_mono16():
    deep = np.arange(4096, dtype=np.uint16).reshape(64, 64)
    decoded = PictureDecoder().decode(compressed(deep, ".png", "mono16; png compressed"))
    np.testing.assert_array_equal(decoded, deep >> 4)


def test_jpeg_is_read_within_its_loss():
    u, v = np.meshgrid(np.arange(64.0), np.arange(48.0))
    picture = (120 + 80 * np.sin(u / 9) * np.cos(v / 7)).astype(np.uint8)
    for form in ("jpeg", "jpg", "bgr8; jpeg compressed bgr8", ""):
        decoded = PictureDecoder().decode(compressed(picture, ".jpg", form))
        assert np.abs(decoded.astype(int) - picture).max() <= 4


def test_a_jpeg_is_not_turned_by_its_exif_tag():
    picture = np.full((16, 32), 90, np.uint8)
    jpeg = bytes(cv2.imencode(".jpg", picture)[1])
    # An APP1 segment whose only tag, 0x0112, says "rotate by 90 degrees" (6).
    tiff = (
        b"MM\x00*\x00\x00\x00\x08\x00\x01\x01\x12\x00\x03\x00\x00\x00\x01\x00\x06\x00\x00"
        + bytes(4)
    )
    body = b"Exif\x00\x00" + tiff
    app1 = b"\xff\xe1" + (len(body) + 2).to_bytes(2, "big") + body
    turned = CompressedImage(format="jpeg", data=jpeg[:2] + app1 + jpeg[2:])
    assert cv2.imdecode(np.frombuffer(turned.data, np.uint8), cv2.IMREAD_GRAYSCALE).shape == (
        32,
        16,
    )
    assert PictureDecoder().decode(turned).shape == (16, 32)


@pytest.mark.parametrize("encoding", ["bayer_rggb8", "32FC1", "yuv422", ""])
def test_an_encoding_that_is_not_read_is_named_with_those_that_are(encoding):
    with pytest.raises(BadInput, match=r"mono8, mono16, bgr8, rgb8") as caught:
        PictureDecoder().decode(message(np.zeros((2, 2), np.uint8), encoding))
    assert repr(encoding) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("form", ["16UC1; compressedDepth png", "tiff", "h264", ""])
def test_a_compression_that_is_not_read_is_named(form):
    with pytest.raises(BadInput, match="read are jpeg and png"):
        PictureDecoder().decode(CompressedImage(format=form, data=b"no picture at all"))


@pytest.mark.parametrize("missing", [1, 8, 47])
def test_a_picture_with_too_few_bytes_is_refused(missing):
    cut = message(np.zeros((6, 8), np.uint8), "mono8")
    cut.data = cut.data[:-missing]
    with pytest.raises(BadPicture, match="8 × 6"):
        PictureDecoder().decode(cut)


def test_the_last_row_may_lack_its_padding():
    picture = np.arange(12, dtype=np.uint8).reshape(3, 4)
    short = message(picture, "mono8", padding=5)
    short.data = short.data[:-5]
    np.testing.assert_array_equal(PictureDecoder().decode(short), picture)


@pytest.mark.parametrize("data", [b"", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff\xe0 and then nothing"])
def test_a_damaged_compressed_picture_is_refused(data):
    with pytest.raises(BadPicture, match="cannot be decoded"):
        PictureDecoder().decode(CompressedImage(format="png", data=data))


def test_an_empty_picture_is_refused():
    with pytest.raises(BadPicture, match="empty"):
        PictureDecoder().decode(Image(encoding="mono8"))
