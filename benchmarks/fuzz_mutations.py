"""Small bags of every kind, and the ways in which they are damaged for `benchmarks.fuzz_bags`."""

import random
import shutil
import struct
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import cv2
import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
RAW, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
TOPIC = "/image_raw"
COUNT = 10
START_NS, PERIOD_NS = 1_700_000_000_000_000_000, 50_000_000
CHUNKS = 5000
"""Bytes of a chunk: four or five pictures."""

Message = tuple[int, bytes]
STORAGES = ("mcap", "mcap zstd", "mcap lz4", "mcap unchunked", "bag mcap", "bag db3", "db3")
PICTURES = ("raw", "jpeg", "png")


@cache
def messages(picture: str) -> tuple[Message, ...]:
    """Return (time of recording, serialised picture)s of a dark bar that moves over noise."""
    made = []
    for number in range(COUNT):
        grey = np.random.default_rng(number).integers(150, 200, (32, 40), np.uint8)
        cv2.line(grey, (6 + number, 16), (20 + number, 18), 30, 4)
        stamp_ns = START_NS + number * PERIOD_NS
        made.append((stamp_ns, serialised(grey, stamp_ns, picture)))
    return tuple(made)


def serialised(grey: np.ndarray, stamp_ns: int, picture: str, encoding: str = "mono8") -> bytes:
    """Return one picture as CDR."""
    types = STORE.types
    stamp = types["builtin_interfaces/msg/Time"](sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="camera")
    if picture == "raw":
        height, width = grey.shape
        message = types[RAW](header, height, width, encoding, 0, width, grey.ravel())
        return bytes(STORE.serialize_cdr(message, RAW))
    data = cv2.imencode(".jpg" if picture == "jpeg" else ".png", grey)[1].ravel()
    return bytes(STORE.serialize_cdr(types[COMPRESSED](header, picture, data), COMPRESSED))


def write(folder: Path, storage: str, picture: str, what: Sequence[Message]) -> Path:
    """Write a bag of a kind; return its path."""
    kind = RAW if picture == "raw" else COMPRESSED
    if storage in ("bag mcap", "bag db3", "db3"):
        plugin = StoragePlugin.MCAP if storage == "bag mcap" else StoragePlugin.SQLITE3
        bag = folder / "bag"
        with BagWriter(bag, version=9, storage_plugin=plugin) as writer:
            connection = writer.add_connection(TOPIC, kind, typestore=STORE)
            for log_ns, data in what:
                writer.write(connection, log_ns, data)
        return bag / "bag.db3" if storage == "db3" else bag
    file = folder / "bag.mcap"
    compression = {"mcap zstd": CompressionType.ZSTD, "mcap lz4": CompressionType.LZ4}
    with file.open("wb") as stream:
        mcap = Writer(
            stream,
            chunk_size=CHUNKS,
            compression=compression.get(storage, CompressionType.NONE),
            use_chunking=storage != "mcap unchunked",
        )
        mcap.start(profile="ros2", library="fuzz")
        definition, _ = STORE.generate_msgdef(kind, ros_version=2)
        schema = mcap.register_schema(kind, "ros2msg", definition.encode())
        channel = mcap.register_channel(TOPIC, "cdr", schema)
        for number, (log_ns, data) in enumerate(what):
            mcap.add_message(channel, log_ns, data, log_ns, number)
        mcap.finish()
    return file


def storage_file(bag: Path) -> Path:
    """Return the one storage file of a bag."""
    if bag.is_file():
        return bag
    return next(file for file in bag.iterdir() if file.suffix in (".mcap", ".db3"))


# Damage to the bytes of a file.


def flip_bit(data: bytearray, rng: random.Random) -> None:
    data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def flip_many(data: bytearray, rng: random.Random) -> None:
    for _ in range(rng.randrange(2, 30)):
        flip_bit(data, rng)


def cut(data: bytearray, rng: random.Random) -> None:
    del data[rng.randrange(len(data)) :]


def zero_range(data: bytearray, rng: random.Random) -> None:
    at, count = _range(data, rng)
    data[at : at + count] = bytes(count)


def scramble_range(data: bytearray, rng: random.Random) -> None:
    at, count = _range(data, rng)
    data[at : at + count] = rng.randbytes(count)


def duplicate_range(data: bytearray, rng: random.Random) -> None:
    at, count = _range(data, rng)
    data[at:at] = data[at : at + count]


def remove_range(data: bytearray, rng: random.Random) -> None:
    at, count = _range(data, rng)
    del data[at : at + count]


def insert_bytes(data: bytearray, rng: random.Random) -> None:
    at = rng.randrange(len(data))
    data[at:at] = rng.randbytes(rng.randrange(1, 300))


def wrong_length(data: bytearray, rng: random.Random) -> None:
    """Write a number where a length may be: eight bytes that make little or much."""
    at = rng.randrange(max(1, len(data) - 8))
    value = rng.choice((0, 1, 255, 4096, 2**31, 2**32 - 1, 2**40, 2**63, 2**64 - 1))
    data[at : at + 8] = value.to_bytes(8, "little")


def wrong_page(data: bytearray, rng: random.Random) -> None:
    """Overwrite a whole page, as a disk that fails does."""
    page = 4096 * rng.randrange(1 + len(data) // 4096)
    data[page : page + 4096] = rng.choice((bytes, rng.randbytes))(4096)


def _range(data: bytearray, rng: random.Random) -> tuple[int, int]:
    at = rng.randrange(len(data))
    return at, min(len(data) - at, int(2 ** rng.uniform(0, 13)))


BYTES: tuple[Callable[[bytearray, random.Random], None], ...] = (
    flip_bit,
    flip_bit,
    flip_many,
    cut,
    zero_range,
    scramble_range,
    duplicate_range,
    remove_range,
    insert_bytes,
    wrong_length,
    wrong_page,
)


# Damage to messages, before they are written.


def bad_message(picture: str, message: Message, rng: random.Random) -> Message:
    """Return a message that is wrong in one of the ways in which messages can be."""
    log_ns, data = message
    grey = np.full((32, 40), 99, np.uint8)
    ways: list[Callable[[], Message]] = [
        lambda: (log_ns, data[: rng.randrange(len(data))]),
        lambda: (log_ns, b""),
        lambda: (log_ns, rng.randbytes(rng.randrange(1, 400))),
        lambda: (log_ns, data + rng.randbytes(rng.randrange(1, 400))),
        lambda: (log_ns, _damaged(data, rng)),
        lambda: (log_ns, serialised(grey, log_ns, "raw", rng.choice(("bayer", "", "32FC1")))),
        lambda: (log_ns, serialised(grey[: rng.randrange(1, 32)], log_ns, picture)),
        lambda: (log_ns, serialised(np.zeros((64, 80), np.uint8), log_ns, picture)),
        lambda: (log_ns, data[:4] + rng.randbytes(8) + data[12:]),
        lambda: (log_ns, data[:4] + struct.pack("<iI", -5, 2**32 - 1) + data[12:]),
        lambda: (rng.choice((0, 2**63 - 1, PERIOD_NS)), data),
        lambda: (log_ns, _large(data, rng)),
    ]
    return rng.choice(ways)()


def _damaged(data: bytes, rng: random.Random) -> bytes:
    changed = bytearray(data)
    rng.choice(BYTES)(changed, rng)
    return bytes(changed)


def _large(data: bytes, rng: random.Random) -> bytes:
    """Write a vast number over four bytes of the first fields: a height, a width, a length."""
    at = rng.randrange(12, min(80, len(data) - 4))
    return data[:at] + struct.pack("<I", rng.choice((30_000, 2**31, 2**32 - 1))) + data[at + 4 :]


# Damage to metadata.yaml.


def edit_metadata(bag: Path, rng: random.Random) -> None:
    """Change a number, lose a line, cut it, write nonsense, list the file twice, or lose it."""
    file = bag / "metadata.yaml"
    lines = file.read_text(encoding="utf-8").splitlines()
    way = rng.randrange(6)
    if way == 0:
        numbers = [k for k, line in enumerate(lines) if line.strip()[-1:].isdigit()]
        k = rng.choice(numbers)
        value = rng.choice((0, 1, 9, 11, 10**6, -3, 2**63, 2**70))
        lines[k] = lines[k].rpartition(" ")[0] + f" {value}"
    elif way == 1:
        del lines[rng.randrange(len(lines))]
    elif way == 2:
        del lines[rng.randrange(len(lines)) :]
    elif way == 3:
        k = rng.randrange(len(lines))
        lines[k] = rng.choice(("- ][", "\t:", "x: !!python/object:os.system 1", "&a [*a, *a]"))
    elif way == 4:
        k = next(k for k, line in enumerate(lines) if "relative_file_paths" in line)
        lines.insert(k + 1, lines[k + 1])
    else:
        file.unlink()
        return
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def damage(folder: Path, storage: str, picture: str, seeds: Path, rng: random.Random) -> Path:
    """Put a damaged bag into an empty folder; return its path."""
    kind = rng.random()
    if kind < 0.3:  # messages
        what = list(messages(picture))
        for k in rng.sample(range(COUNT), rng.randrange(1, 4)):
            what[k] = bad_message(picture, what[k], rng)
        return write(folder, storage, picture, what)
    seed = seeds / f"{storage} {picture}"
    shutil.copytree(seed, folder, dirs_exist_ok=True)
    bag = folder / "bag" if (folder / "bag").is_dir() else folder / "bag.mcap"
    if storage == "db3":
        bag = bag / "bag.db3"
    if storage.startswith("bag") and kind < 0.5:
        edit_metadata(bag, rng)
        if kind < 0.4:
            return bag
    file = storage_file(bag)
    data = bytearray(file.read_bytes())
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        if data:
            rng.choice(BYTES)(data, rng)
    file.write_bytes(data)
    return bag
