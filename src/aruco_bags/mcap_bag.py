"""MCAP files of ROS 1: reading them in parts, as an IndexedBag does with bags, and writing them."""
import os
from contextlib import ExitStack
from functools import lru_cache

import genpy
import rosbag
from aruco_ar.base.errors import InputError
from aruco_ar.base.versions import SetupError, need
from genpy.dynamic import generate_dynamic

MCAP_SUFFIX = '.mcap'
MAGIC = b'\x89MCAP0\r\n'
PROFILE, ENCODING, SCHEMAS = 'ros1', 'ros1', 'ros1msg'  # MCAP's names for what is of ROS 1
HEAD_BYTES = 9  # of a record, before what is in it


def need_mcap(instead):
    """Raise InputError if the library for MCAP is missing. ``instead``: what to do without it."""
    try:
        need('mcap')
    except SetupError as error:
        raise InputError('%s Or %s.' % (error, instead)) from None


def is_mcap(path):
    """Whether a file is an MCAP file, whatever its name."""
    with open(path, 'rb') as file:
        return file.read(len(MAGIC)) == MAGIC


class McapBag:
    """An MCAP file of ROS 1 to read from, part by part: it has the methods of an IndexedBag.

    Only the index of its chunks is in memory. Raises InputError if it has none, or if its messages are not
    those of ROS 1, and what the library raises.
    """

    def __init__(self, path):
        need_mcap('convert it to a bag')
        from mcap.reader import make_reader
        with ExitStack() as stack:
            self._file = stack.enter_context(open(path, 'rb'))
            self._reader = make_reader(self._file, validate_crcs=True)
            self._summary = self._summary_of(path)
            self._open = stack.pop_all()
        self._chunks = [chunk for chunk in self._summary.chunk_indexes if chunk.uncompressed_size]
        if not all(chunk.message_index_offsets for chunk in self._chunks):
            self._chunks = []  # the whole file is read instead

    def _summary_of(self, path):
        length = self._file.seek(0, os.SEEK_END)
        self._file.seek(max(length - len(MAGIC), len(MAGIC)))
        summary = self._reader.get_summary() if self._file.read() == MAGIC else None
        if summary is None:
            raise InputError('it has no index; perhaps its recording was interrupted. Make one: mcap recover '
                             '"%s" -o whole.mcap' % path)
        encodings = {channel.message_encoding for channel in summary.channels.values()}
        if encodings and ENCODING not in encodings:
            raise InputError('its messages are not of ROS 1: their encoding is %s. Give a recording of ROS 1.'
                             % ', '.join(sorted(encodings)))
        return summary

    def close(self):
        """Close the file."""
        self._open.close()

    def topics(self):
        """{name of a topic with messages: its type}."""
        used = {number for chunk in self._chunks for number in chunk.message_index_offsets}
        if not self._chunks:
            used = {message.channel_id for _, _, message in self._reader.iter_messages()}
        channels = sorted((self._summary.channels[number] for number in used), key=lambda each: each.topic)
        return {channel.topic: self._summary.schemas[channel.schema_id].name for channel in channels
                if channel.message_encoding == ENCODING}

    def begin(self):
        """The genpy.Time of the first message."""
        return genpy.Time(0, min([chunk.message_start_time for chunk in self._chunks] or
                         [message.log_time for _, _, message in self._reader.iter_messages()]))

    def times(self, topics):
        """(topic, genpy.Time) of all messages on topics, chunk by chunk, not in order."""
        from mcap.data_stream import ReadDataStream
        from mcap.records import MessageIndex
        if not self._chunks:
            for _, channel, message in self._reader.iter_messages(topics, log_time_order=False):
                yield channel.topic, genpy.Time(0, message.log_time)
        for chunk in self._chunks:
            for number, place in chunk.message_index_offsets.items():
                topic = self._summary.channels[number].topic
                if topic in topics:
                    self._file.seek(place + HEAD_BYTES)
                    for time, _ in MessageIndex.read(ReadDataStream(self._file)).records:
                        yield topic, genpy.Time(0, time)

    def messages(self, topics, begin, end):
        """(topic, message, time) from one genpy.Time to another, both included, in order of time."""
        found = self._reader.iter_messages(topics, starting_at=begin.to_nsec(), ending_at=end.to_nsec())
        for schema, channel, message in found:
            if schema is not None and channel.message_encoding == ENCODING:
                kind = _kind(schema.name, schema.data)
                yield channel.topic, kind().deserialize(message.data), genpy.Time(0, message.log_time)


def join_mcaps(parts, target):
    """Write the messages of several bags to a new MCAP file, bag after bag. All arguments are paths.

    Chunks are not compressed, since what is large in them, JPEGs, is.
    """
    from mcap.writer import CompressionType, Writer
    schemas, channels = {}, {}
    with open(target, 'wb') as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start(PROFILE)
        for part in parts:
            with rosbag.Bag(part) as bag:
                for topic, (name, data, md5sum, _, kind), time in bag.read_messages(raw=True):
                    if name not in schemas:
                        schemas[name] = writer.register_schema(name, SCHEMAS, kind._full_text.encode())
                    if topic not in channels:
                        channels[topic] = writer.register_channel(topic, ENCODING, schemas[name],
                                                                  {'md5sum': md5sum})
                    writer.add_message(channels[topic], time.to_nsec(), data, time.to_nsec())
        writer.finish()


@lru_cache(maxsize=None)
def _kind(name, definition):
    """The class of the messages of a type."""
    return generate_dynamic(name, definition.decode())[name]
