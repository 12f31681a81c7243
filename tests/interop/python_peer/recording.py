# SPDX-License-Identifier: Apache-2.0
"""Recordings in MCAP, beside libraries that share no code with Tandem: `mcap`, `mcap-ros2-support`, `rosbags`.

    recording.py compare DIR       reads a recording by each, and compares topics, times, bytes, decoded fields
                                   and type hashes
    recording.py rewrite DIR OUT   writes its messages again, each way below OUT in another form

Exit 0 if all agree.
"""
import dataclasses
import pathlib
import sys

from mcap.reader import NonSeekingReader, SeekingReader
from mcap.writer import CompressionType, IndexType, Writer
from mcap_ros2.decoder import DecoderFactory
from rosbags import rosbag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore


def mcap_of(folder):
    (file,) = pathlib.Path(folder).glob("*.mcap")
    return file


def read_by_mcap(reader, folder):
    with open(mcap_of(folder), "rb") as stream:
        return [(channel.topic, message.log_time, message.data)
                for _, channel, message in reader(stream, validate_crcs=True).iter_messages()]


def read_by_rosbags(folder):
    with rosbag2.Reader(folder) as reader:
        return [(connection.topic, time, bytes(raw)) for connection, time, raw in reader.messages()]


def schemas_of(folder):
    with open(mcap_of(folder), "rb") as stream:
        summary = SeekingReader(stream, validate_crcs=True).get_summary()
    assert summary.statistics.message_count == sum(summary.statistics.channel_message_counts.values())
    assert all(schema.encoding == "ros2msg" for schema in summary.schemas.values()), summary.schemas
    return summary


def types_of(summary):
    store = get_typestore(Stores.EMPTY)
    for schema in summary.schemas.values():
        store.register(get_types_from_msg(schema.data.decode(), schema.name))
    return store


def names_of(message):
    """Those of its fields; rosbags has the type's name and constants among them."""
    names = [field.name for field in dataclasses.fields(message)]
    return [name for name in names if name != "__msgtype__" and not name.isupper()]


def check_same(one, other, where):
    """`one` is rosbags' message or a part of it, `other` that of mcap_ros2."""
    if dataclasses.is_dataclass(one):
        for name in names_of(one):
            check_same(getattr(one, name), getattr(other, name), f"{where}.{name}")
    elif hasattr(one, "__len__") and not isinstance(one, (str, bytes)):
        one, other = list(one), list(other)
        assert len(one) == len(other), where
        for i, parts in enumerate(zip(one, other)):
            check_same(*parts, f"{where}[{i}]")
    else:
        assert one == other or (one != one and other != other), f"{where}: {one} != {other}"


def check_decoded(folder, summary, store):
    decoded = 0
    last = {}
    with open(mcap_of(folder), "rb") as stream:
        reader = SeekingReader(stream, decoder_factories=[DecoderFactory()])
        for schema, channel, message, value in reader.iter_decoded_messages():
            decoded += 1
            last[channel.topic] = (schema.name, message.data, value)
    for topic, (name, data, value) in last.items():  # the slow comparison, of one message of each topic
        check_same(store.deserialize_cdr(data, name), value, topic)
    for channel in summary.channels.values():
        name = summary.schemas[channel.schema_id].name
        assert channel.metadata["topic_type_hash"] == store.hash_rihs01(name), f"{channel.topic}: {name}"
        assert "reliability: " in channel.metadata["offered_qos_profiles"]
    return decoded


def compare(folder):
    summary = schemas_of(folder)
    messages = read_by_mcap(SeekingReader, folder)
    assert sorted(messages) == sorted(read_by_mcap(NonSeekingReader, folder))
    assert sorted(messages) == sorted(read_by_rosbags(folder))
    assert [time for _, time, _ in messages] == sorted(time for _, time, _ in messages)
    assert len(messages) == summary.statistics.message_count == check_decoded(folder, summary, types_of(summary))
    print(len(messages), "messages of", len({topic for topic, _, _ in messages}), "topics")


def rewrite_by_mcap(summary, messages, file, **options):
    file.parent.mkdir()
    with open(file, "wb") as stream:
        writer = Writer(stream, **options)
        writer.start("ros2", "recording.py")
        schemas = {id: writer.register_schema(schema.name, schema.encoding, schema.data)
                   for id, schema in summary.schemas.items()}
        channels = {channel.topic: writer.register_channel(channel.topic, channel.message_encoding,
                                                           schemas[channel.schema_id], channel.metadata)
                    for channel in summary.channels.values()}
        for topic, time, data in messages:
            writer.add_message(channels[topic], time, data, time)
        writer.finish()


def rewrite_by_rosbags(folder, to, store):
    with rosbag2.Reader(folder) as reader, rosbag2.Writer(
            to, version=rosbag2.Writer.VERSION_LATEST, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
        connections = {}
        for connection, time, raw in reader.messages():
            if connection.id not in connections:
                connections[connection.id] = writer.add_connection(
                    connection.topic, connection.msgtype, typestore=store,
                    offered_qos_profiles=connection.ext.offered_qos_profiles)
            writer.write(connections[connection.id], time, raw)


def rewrite(folder, out):
    summary = schemas_of(folder)
    messages = read_by_mcap(SeekingReader, folder)
    out.mkdir()
    rewrite_by_rosbags(folder, out / "rosbags", types_of(summary))
    rewrite_by_mcap(summary, messages, out / "zstd" / "a.mcap", compression=CompressionType.ZSTD)
    rewrite_by_mcap(summary, messages, out / "lz4" / "a.mcap", compression=CompressionType.LZ4)
    rewrite_by_mcap(summary, messages, out / "plain" / "a.mcap", compression=CompressionType.NONE)
    rewrite_by_mcap(summary, messages, out / "unindexed" / "a.mcap", index_types=IndexType.NONE,
                    repeat_channels=False, repeat_schemas=False, use_statistics=False, use_summary_offsets=False)
    rewrite_by_mcap(summary, messages, out / "unchunked" / "a.mcap", use_chunking=False)
    cut = out / "cut"
    cut.mkdir()
    # a killed recorder leaves no end
    (cut / "a.mcap").write_bytes((out / "zstd" / "a.mcap").read_bytes()[:-100])


if __name__ == "__main__":
    if sys.argv[1:2] == ["compare"] and len(sys.argv) == 3:
        compare(sys.argv[2])
    elif sys.argv[1:2] == ["rewrite"] and len(sys.argv) == 4:
        rewrite(sys.argv[2], pathlib.Path(sys.argv[3]))
    else:
        sys.exit(__doc__)
