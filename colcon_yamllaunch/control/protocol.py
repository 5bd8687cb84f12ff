# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

r"""
What a running launch and its clients say to one another.

Each message is a JSON object on a line of its own, in UTF-8. A client sends
requests; each is answered by one object, in order. A request has `version`,
which is :data:`VERSION`, and `request`:

- `status`: the answer has the launch as `launch`, see
  `engine.state.to_json`;
- `stop` and `restart`, with the label of a process as `member`, or what ROS 2
  calls it; that of a component, or the full name of its node, has it unloaded,
  or loaded anew;
- `kill`, with such a name of a process: SIGKILL for all of it, at once; it
  counts as stopped on request;
- `debug`, likewise: it is restarted under a debugger, in a terminal that
  `attach` types at; with a TCP port as `port`, under one that waits for an
  editor there. Its next start is without the debugger;
- `describe`, with the name of a process or component: the answer has it as
  `description`, see `description.Description`;
- `tree`: the answer has the launch files, groups and timers of the plan, with
  the processes and components in them, as `tree`, a list of
  `description.Branch`;
- `watch`, with `pause` or `resume` as `action`: nothing follows from changes
  of files (`--watch`) until it is resumed, and then what follows from those
  since;
- `change_state`, with the label or the full name of a lifecycle node as
  `member`, and one of `plan.TRANSITIONS` as `transition`: it is
  answered when the node has done it, or has not;
- `shutdown`: everything is stopped; the connection ends with the launch;
- `escalate`: the next step of stopping everything is taken at once, as by a
  second Ctrl-C;
- `attach`, with a name of a process: from the answer on, the client sends
  `{"keys": TEXT}` to type at the process, and gets `{"output": TEXT}` for
  what it writes, `{"skipped": NUMBER}` where that many bytes were lost
  because the client is slow, `{"started": PID}`, and `{"ended": TEXT,
  "again": BOOLEAN}`, which says how the process ended and whether it is
  respawned. In `keys` and `output` each character stands for the byte of its
  number (ISO 8859-1);
- `subscribe`, to be told what happens, see below;
- `ping`: the answer has the time of the launcher as `clock`, in seconds since
  the epoch. With `ack`, a point, the holder acknowledges what it has, see
  below; with `"reconnecting": true` it says that it goes on by another
  connection.

An answer has `version` and `ok`. Where that is false, `error` says why in one
line; after an error of form the server closes the connection. Requests of
another version get an error that names the server's. Unknown keys are
ignored, so that they can be added without a new version.

A request may have an `id`, a text or a number, which its answer has, too.
Such requests need not wait for one another: one that takes its time is
answered when it is done, after others that came later.

`subscribe` takes `since`, a point in the course of the launch, by default now;
`events` and `output`, whether these are wanted, by default true; `processes`,
a list with the labels of those whose output that is, by default null, for all;
and `behind`, how many bytes of output the client may be behind before it
misses some, by default as many as the launch allows. A point is
`{"events": NUMBER, "bytes": NUMBER}`: how many events there have been before
it, and how many bytes of output of all processes; with two zeros it is the
beginning. The answer has `launch`, as that of `status`, and `now`, the point
where it is in that state. From the answer on
come, in the order in which things happened,

- `{"event": OBJECT}`, a line of `events.jsonl`, with its `time`;
- `{"output": {"process": LABEL, "stream": "stdout" or "stderr", "data": TEXT,
  "time": SECONDS, "at": NUMBER}}`, whole lines as they were written, with a
  character for each byte, and how many bytes of output there were before;
- with `"states": true`, `{"state": OBJECT}` after the events that changed the
  state of the launch, or where no event tells of the change. It has the fields
  of `launch`, but only those `processes` and `components` that changed, and
  `labels`, the labels of all of them in order, where one came or went;
- `{"missed": {"events": NUMBER, "bytes": NUMBER}}` where that much is lost
  that was asked for, as it is too long ago, or the client too slow. Whose
  output it was, nobody knows any more: it counts that of all processes.

With `"raw": true`, `output` has `bytes` in place of `data`: how many bytes
follow the end of its line. They are the output as it is.

With `"relayed": true`, an empty line follows output that does not end a line,
as some connections to machines pass on whole lines only. While the connection
is slow, messages come packed: `{"packed": {"bytes": NUMBER}}` and so many
bytes, which are messages compressed by zlib, and an empty line.

One client may hold the launch: it gives `holder`, a text of its own, which no
other client may give from then on. What it has not acknowledged with `ping` is
kept for it: all events, and as much output as the logs may take. So it can go
on with another connection at the point that it has come to, and misses
nothing. With `lease`, a number of seconds, the launch is stopped when nothing
comes from the holder for so long; so it sends `ping` more often than that.
The ids of its requests are numbers that increase. The answer to `subscribe`
has the last of them as `asked`, so that it can send again what was not
executed, and only that. It may send commands that are not public, and as many
requests at the same time as it likes.

A part of a launch on a machine has another socket, for its launcher, which
holds it. There, events also come that are internal, see `events.Event`.

What happened before `now` comes first. Whoever adds up what came and what was
missed knows the point to go on from with another connection. Meanwhile the
connection takes all requests but `attach`; only answers have `ok`. Another
`subscribe` takes the place of the first, and goes on where that one is unless
it has `since`; it may want other things.
"""

from collections.abc import Callable, Iterator, Mapping
import json
from typing import Any

#: The version of the protocol.
VERSION = 1
#: Bytes of the longest request that a server reads, and of that of the holder.
MAXIMUM_REQUEST = 64 * 1024
MAXIMUM_HOLDER_REQUEST = 64 * 1024 * 1024
#: Bytes of output that wait for a client that is attached, before some is
#: skipped.
MAXIMUM_BACKLOG = 1024 * 1024
#: Bytes of output in one message to a client that has subscribed.
MAXIMUM_OUTPUT = 32 * 1024
#: Requests with an `id` that may wait for an answer; further ones are not read
#: until one has come.
MAXIMUM_UNANSWERED = 32
#: Clients at the same time; when there are more, the oldest has to go that is
#: not attached, and has not subscribed.
MAXIMUM_CLIENTS = 32
#: Bytes of the longest message of a launch, and of the bytes that follow one.
MAXIMUM_MESSAGE = 64 * 1024 * 1024
# messages that bytes follow; see `protocol`
_RAW = ('output', 'shown', 'packed', 'stream')


class ProtocolError(Exception):
    """A message makes no sense; the text says why, in one line."""


def encode(message: Mapping[str, Any]) -> bytes:
    """Return a message as a line."""
    return json.dumps(message, separators=(',', ':')).encode() + b'\n'


def decode(line: bytes) -> dict[str, Any]:
    """
    Read a message.

    :raises ProtocolError: when it is none
    """
    try:
        message = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise ProtocolError('this is not JSON') from error
    if not isinstance(message, dict):
        raise ProtocolError('a message is a JSON object')
    return message


def encode_raw(kind: str, fields: Mapping[str, Any], data: bytes) -> bytes:
    """Return a message as a line, and bytes that follow it as they are."""
    return encode({kind: {**fields, 'bytes': len(data)}}) + data


def request(name: str, **more: Any) -> dict[str, Any]:
    """Return a request."""
    return {'version': VERSION, 'request': name, **more}


def success(**more: Any) -> dict[str, Any]:
    """Return the answer to a request that was done."""
    return {'version': VERSION, 'ok': True, **more}


def failure(reason: str) -> dict[str, Any]:
    """Return the answer to a request that was not done."""
    return {'version': VERSION, 'ok': False, 'error': reason}


def text_of(data: bytes) -> str:
    """Return bytes as a text that JSON can hold."""
    return data.decode('latin-1')


def bytes_of(text: object) -> bytes:
    """
    Return the bytes that :func:`text_of` made a text of.

    :raises ProtocolError: when it is no such text
    """
    if not isinstance(text, str):
        raise ProtocolError('keys and output are texts')
    try:
        return text.encode('latin-1')
    except UnicodeEncodeError as error:
        reason = 'keys and output have a byte a character'
        raise ProtocolError(reason) from error


class MessageReader:
    """
    The messages in a stream of bytes, with bounded memory.

    Bytes that follow a message are its `data`, and packed messages are
    unpacked.
    """

    def __init__(
        self, decode: Callable[[bytes], dict[str, Any]] = decode
    ) -> None:
        self._decode = decode
        self._data = bytearray()
        # a message whose bytes have not all come, and their number
        self._incomplete: tuple[dict[str, Any], dict[str, Any], int] | None
        self._incomplete = None
        # where a search for the end of a line goes on
        self._searched = 0

    def feed(self, data: bytes) -> Iterator[dict[str, Any]]:
        """
        Iterate over the messages that are complete now.

        :raises ProtocolError: when there is something else; what comes after
          that is not to be read
        """
        self._data += data
        while (message := self._next()) is not None:
            packed = message.get('packed')
            if packed is None:
                yield message
            else:
                yield from self._unpacked(packed['data'])

    def _next(self) -> dict[str, Any] | None:
        if self._incomplete is None:
            line = self._line()
            if line is None:
                return None
            message = self._decode(line)
            fields, size = _raw_fields(message)
            if not fields:
                return message
            self._incomplete = message, fields, size
        message, fields, size = self._incomplete
        if len(self._data) < size:
            return None
        self._incomplete = None
        fields['data'] = bytes(memoryview(self._data)[:size])
        del self._data[:size]
        return message

    def _line(self) -> bytes | None:
        """Return the next line that is not empty, None if it has not come."""
        line = b'\n'
        while line == b'\n':
            end = self._data.find(b'\n', self._searched) + 1
            if not end:
                self._searched = len(self._data)
                if self._searched > MAXIMUM_MESSAGE:
                    raise ProtocolError('a message is too long')
                return None
            line = bytes(memoryview(self._data)[:end])
            del self._data[:end]
            self._searched = 0
        return line

    def _unpacked(self, data: bytes) -> Iterator[dict[str, Any]]:
        import zlib

        unpacker = zlib.decompressobj()
        try:
            # so that a few bytes do not become gigabytes
            content = unpacker.decompress(data, MAXIMUM_MESSAGE)
        except zlib.error as error:
            raise ProtocolError('a packed message is damaged') from error
        if not unpacker.eof:
            raise ProtocolError('a packed message is damaged or too long')
        reader = MessageReader(self._decode)
        for message in reader.feed(content):
            if 'packed' in message:
                raise ProtocolError('a message is packed twice')
            yield message


def _raw_fields(message: dict[str, Any]) -> tuple[dict[str, Any], int]:
    """Return what bytes follow a message, and how many; empty for none."""
    for kind in _RAW:
        fields = message.get(kind)
        if isinstance(fields, dict) and 'bytes' in fields:
            size = fields['bytes']
            if type(size) is not int or not 0 <= size <= MAXIMUM_MESSAGE:
                raise ProtocolError('a message has a wrong number of bytes')
            return fields, size
    if 'packed' in message:
        raise ProtocolError('a packed message has no bytes')
    return {}, 0
