# SPDX-License-Identifier: GPL-3.0-or-later
"""Multipart messages of Drogue's protocol (proto/drogue/v1/wire.proto) from and to ZeroMQ frames."""

import zlib
from dataclasses import dataclass, field

import numpy as np

from drogue.v1 import wire_pb2

VERSION = 1
MAGIC = b"DRGW" + bytes([VERSION])
MAX_ARRAYS = 64
MAX_FRAME_BYTES = 8 << 30
MAX_ENVELOPE_BYTES = 1 << 20

_FLOAT64 = wire_pb2.ArrayHeader.FLOAT64
_INT64 = wire_pb2.ArrayHeader.INT64
_TYPES = {_FLOAT64: np.dtype("<f8"), _INT64: np.dtype("<i8")}


class WireError(Exception):
    """A malformed message: says what was expected and what came."""


@dataclass
class Message:
    """An envelope and the arrays behind it by name, float64 or int64; Envelope.array is filled by encode()."""

    envelope: wire_pb2.Envelope = field(default_factory=wire_pb2.Envelope)
    arrays: dict = field(default_factory=dict)


def encode(message):
    """The frames of a message."""
    envelope = wire_pb2.Envelope()
    envelope.CopyFrom(message.envelope)
    del envelope.array[:]
    frames = []
    for name, values in message.arrays.items():
        values = np.asarray(values)
        integers = np.issubdtype(values.dtype, np.integer)
        kind = _INT64 if integers else _FLOAT64
        data = np.ascontiguousarray(values, dtype=_TYPES[kind]).tobytes()
        envelope.array.add(name=name, type=kind, shape=values.shape, byte_length=len(data), crc32=zlib.crc32(data))
        frames.append(data)
    return [MAGIC, envelope.SerializeToString(), *frames]


def decode(frames):
    """The message of some frames (bytes, or ZeroMQ's own); verifies magic, version, sizes and checksums. The arrays lie
    in the frames: nothing is copied. Raises WireError."""
    frames = [memoryview(frame) for frame in frames]
    if len(frames) < 2:
        raise WireError(f"a message of {len(frames)} frames is too short: magic and envelope expected")
    if frames[0].nbytes > MAX_ENVELOPE_BYTES or frames[1].nbytes > MAX_ENVELOPE_BYTES:
        raise WireError(f"an envelope of more than {MAX_ENVELOPE_BYTES} bytes")
    magic, body = frames[0].tobytes(), frames[1].tobytes()
    if len(magic) != len(MAGIC) or magic[:4] != MAGIC[:4]:
        raise WireError('not a Drogue message: the first frame must be "DRGW" and the version')
    if magic[4] != VERSION:
        raise WireError(f"the peer speaks protocol version {magic[4]}, this side version {VERSION}")
    message = Message()
    try:
        message.envelope.ParseFromString(body)
    except Exception as error:  # protobuf raises its own DecodeError
        raise WireError(f"the envelope cannot be parsed ({len(body)} bytes)") from error
    headers = message.envelope.array
    if len(headers) > MAX_ARRAYS:
        raise WireError(f"a message of more than {MAX_ARRAYS} arrays")
    if len(frames) != 2 + len(headers):
        raise WireError(f"the envelope announces {len(headers)} arrays, {len(frames) - 2} frames follow")
    for header, frame in zip(headers, frames[2:]):
        if header.name in message.arrays:
            raise WireError(f'array "{header.name}" comes twice')
        message.arrays[header.name] = _unpack(header, frame)
    return message


def _unpack(header, frame):
    shape = tuple(header.shape)
    count = 1
    for extent in shape:
        count *= extent
    if count * 8 != header.byte_length:
        raise WireError(f'array "{header.name}": shape {_braces(shape)} does not make {header.byte_length} bytes')
    if frame.nbytes != header.byte_length:
        raise WireError(f'array "{header.name}": expected {header.byte_length} bytes, the frame has {frame.nbytes}')
    checksum = zlib.crc32(frame)
    if checksum != header.crc32:
        raise WireError(
            f'array "{header.name}": checksum {header.crc32:08x} expected, the frame has {checksum:08x}'
        )
    if header.type not in _TYPES:
        raise WireError(f'array "{header.name}" has an unknown type ({header.type})')
    return np.frombuffer(frame, dtype=_TYPES[header.type]).reshape(shape)


def _braces(shape):
    return "{" + ", ".join(str(extent) for extent in shape) + "}"
