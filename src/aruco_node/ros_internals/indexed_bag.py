"""Long bags: reading them part by part, and writing them.

Symptom: rosbag reads the index of all messages as soon as one is asked for. Of a long bag this takes more
memory than there is, and rosbag does it again for each part. A bag that is written keeps the index of all
messages in memory, too.
Private: ``_chunks``, ``_connections``, ``_connection_indexes``, ``_get_connections`` and
``_reader._read_connection_index_records`` of ``rosbag.Bag``. Without them, the whole index is read.
Seen with: rosbag 1.15 and 1.17. It can go when rosbag reads the index of a part alone. The library rosbags
(0.11.9) is a little faster, but keeps the index of all messages in memory.
"""
import genpy
import rosbag

from . import warn_of_other

PRIVATE = '_chunks', '_connections', '_connection_indexes', '_get_connections', '_reader'
PRIVATE_OF_READER = '_read_connection_index_records'


class IndexedBag:
    """A bag to read from, part by part. Raises what rosbag.Bag raises."""

    def __init__(self, path):
        self._bag = rosbag.Bag(path, skip_index=True)
        if _is_known(self._bag):
            self._chunks, self._connections = self._bag._chunks, dict(self._bag._connections)
        else:
            warn_of_other('rosbag', 'Reading a long bag takes much time and memory.')
            self._bag.close()
            self._bag, self._chunks = rosbag.Bag(path), []

    def close(self):
        """Close the file."""
        self._bag.close()

    def topics(self):
        """{name of a topic with messages: its type}."""
        self._use_all_chunks()
        found = self._bag.get_type_and_topic_info().topics
        return {topic: about.msg_type for topic, about in sorted(found.items()) if about.message_count}

    def begin(self):
        """The genpy.Time of the first message."""
        if self._chunks:
            return min(chunk.start_time for chunk in self._chunks)
        return genpy.Time.from_sec(self._bag.get_start_time())

    def times(self, topics):
        """(topic, genpy.Time) of all messages on topics, chunk by chunk, not in order."""
        if not self._chunks:
            for topic, _, time in self._bag.read_messages(topics, raw=True):
                yield topic, time
        for chunk in self._chunks:
            self._read_index([chunk])
            for connection in self._bag._get_connections(topics):
                for entry in self._bag._connection_indexes[connection.id]:
                    yield connection.topic, entry.time

    def messages(self, topics, begin, end):
        """(topic, message, time) from one genpy.Time to another, both included, in order of time."""
        if self._chunks:
            self._read_index([chunk for chunk in self._chunks
                              if chunk.start_time <= end and chunk.end_time >= begin])
        yield from self._bag.read_messages(topics, begin, end)

    def _use_all_chunks(self):
        if self._chunks:
            self._bag._chunks, self._bag._connections = self._chunks, dict(self._connections)

    def _read_index(self, chunks):
        self._use_all_chunks()
        self._bag._chunks = chunks
        self._bag._connection_indexes = {number: [] for number in self._connections}
        self._bag._reader._read_connection_index_records()
        for index in self._bag._connection_indexes.values():
            index.sort()


def forget_written(bag):
    """Drop the index in memory of what has been written to a rosbag.Bag. The file keeps its own."""
    try:
        bag._connection_indexes.clear()
    except AttributeError:
        warn_of_other('rosbag', 'Writing a long bag takes much memory.')


def _is_known(bag):
    """Whether an open rosbag.Bag has the private parts."""
    if not all(hasattr(bag, name) for name in PRIVATE):
        return False
    # Bags from before ROS Electric have no chunks; their whole index has been read, by another reader.
    return not bag._chunks or hasattr(bag._reader, PRIVATE_OF_READER)
