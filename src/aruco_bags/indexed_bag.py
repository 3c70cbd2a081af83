"""A bag, of which as much of the index is read as is needed."""
import genpy
import rosbag


class IndexedBag:
    """A bag to read from, part by part. Raises what rosbag.Bag raises.

    rosbag itself reads the index of all messages as soon as one is asked for, which of a long bag
    takes more memory than there is, and goes through it from the beginning for each part.
    """

    def __init__(self, path):
        self._bag = rosbag.Bag(path, skip_index=True)
        # Bags of before ROS Electric have none; the index of those has been read.
        self._chunks, self._connections = self._bag._chunks, dict(self._bag._connections)

    def close(self):
        self._bag.close()

    def topics(self):
        """{name of a topic with messages: its type}."""
        self._all()
        found = self._bag.get_type_and_topic_info().topics
        return {topic: about.msg_type for topic, about in sorted(found.items()) if about.message_count}

    def begin(self):
        """The genpy.Time of the first message."""
        if self._chunks:
            return min(chunk.start_time for chunk in self._chunks)
        return genpy.Time.from_sec(self._bag.get_start_time())

    def times(self, topics):
        """(topic, genpy.Time) of all messages on topics, chunk by chunk, not in order."""
        for chunk in self._chunks or [None]:
            if chunk is not None:
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

    def _all(self):
        self._bag._chunks, self._bag._connections = self._chunks, dict(self._connections)

    def _read_index(self, chunks):
        self._all()
        self._bag._chunks = chunks
        self._bag._connection_indexes = {number: [] for number in self._connections}
        self._bag._reader._read_connection_index_records()
        for index in self._bag._connection_indexes.values():
            index.sort()
