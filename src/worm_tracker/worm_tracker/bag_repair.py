"""Saves what can still be read of a cut or damaged .mcap file into a whole one."""

import sys
from pathlib import Path

from mcap.records import Channel, Message, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from worm_msgs_py.errors import BadInput


def repair(damaged: Path, repaired: Path) -> int:
    """Copy every message up to the damage into a new file, with index and checksums.

    Parameters
    ----------
    damaged : Path
        An .mcap file that was cut short or is damaged further on.
    repaired : Path
        The file to write; it must not exist.

    Returns
    -------
    int
        Number of messages that were saved.

    Raises
    ------
    BadInput
        `damaged` is not there, `repaired` is, or not one message can be read.
    """
    if not damaged.is_file():
        raise BadInput(f"{damaged}: no such file")
    if repaired.exists():
        raise BadInput(f"{repaired}: exists already; choose another name")
    partial = repaired.with_name(repaired.name + ".partial")
    try:
        with damaged.open("rb") as source, partial.open("wb") as target:
            writer = Writer(target, compression=CompressionType.ZSTD)
            writer.start(profile="ros2", library="worm-escape")
            saved = _copy(StreamReader(source, validate_crcs=True), writer)
            writer.finish()
        if saved == 0:
            raise BadInput(f"{damaged}: not one message can be read; nothing can be saved")
        partial.rename(repaired)
    finally:
        partial.unlink(missing_ok=True)
    return saved


def _copy(reader: StreamReader, writer: Writer) -> int:
    """Copy records until the reader meets the damage; return the number of messages."""
    schemas: dict[int, int] = {}
    channels: dict[int, int] = {}
    saved = 0
    try:
        for record in reader.records:
            if isinstance(record, Schema) and record.id not in schemas:
                schemas[record.id] = writer.register_schema(
                    record.name, record.encoding, record.data
                )
            elif isinstance(record, Channel) and record.id not in channels:
                channels[record.id] = writer.register_channel(
                    record.topic,
                    record.message_encoding,
                    schemas.get(record.schema_id, 0),
                    record.metadata,
                )
            elif isinstance(record, Message):
                writer.add_message(
                    channels[record.channel_id],
                    record.log_time,
                    record.data,
                    record.publish_time,
                    record.sequence,
                )
                saved += 1
    except OSError:
        raise  # the disk is full, not the bag damaged
    except Exception as error:  # the damage: EndOfFile, struct.error, ZstdError, CRC, ...
        print(f"stopped at the damage: {error or type(error).__name__}", file=sys.stderr)
    return saved


def main() -> int:
    """Run ``python -m worm_tracker.bag_repair DAMAGED.mcap REPAIRED.mcap``."""
    if len(sys.argv) != 3:
        print(main.__doc__, file=sys.stderr)
        return 2
    try:
        saved = repair(Path(sys.argv[1]), Path(sys.argv[2]))
    except (BadInput, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    print(f"{saved} messages saved in {sys.argv[2]}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
