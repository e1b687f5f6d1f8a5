"""Reads Strobe's LCM logs: a host's host-*.lcmlog, strobed's journal-*.lcmlog, or lcm-logger's.

    import strobe_log
    for record in strobe_log.read("today/host-20260131T093000Z.lcmlog", kinds={"SHOT"}):
        print(record.utc_us, record.message.shot_id, len(record.message.flashes))

Needs Python 3 and strobe_msgs, which lcm-gen makes of the .lcm files; no LCM, and numpy for columns() alone. Reads one
record at a time, and goes on after damage.
"""

import collections
import hashlib
import hmac
import importlib
import os
import struct

_SYNC = b"\xed\xa1\xda\x01"
_HEADER = struct.Struct(">4sqqii")
_LONGEST_CHANNEL = 1000
_LARGEST_MESSAGE = 1 << 20  # strobe's own are smaller
_PART = 1 << 16

_SEAL_MAGIC = b"STROBES1"
_SEAL = struct.Struct(">8s4sqq16s")

_TYPES = {"STATUS": "status_t", "COMMAND": "sealed_command_t", "EVENT": "event_t", "SHOT": "shot_t",
          "FRAME": "frame_t", "READOUT": "readout_t"}
_FORMER_TYPES = {"FRAME": ["frame_4_t", "frame_3_t", "frame_2_t"]}

#: What stands behind a sealed message: fingerprint of the key (hexadecimal), who sealed it, its number of the packet.
Seal = collections.namedtuple("Seal", "fingerprint sender number")

#: One record of a log. utc_us: when it was written, microseconds since 1970. message: an object of strobe_msgs; None if
#: the bytes are no message of a version known; a FRAME of former logs is a frame_4_t, frame_3_t or frame_2_t. seal:
#: None if the packet has none. verified: whether the seal is the given key's; None where no key was given.
Record = collections.namedtuple("Record", "utc_us channel kind message seal verified")


def read_key(path=None):
    """The lab's key, 32 bytes: of the file, else of $STROBE_KEY_FILE, else of ~/.config/strobe/lab.key."""
    path = path or os.environ.get("STROBE_KEY_FILE") or os.path.expanduser("~/.config/strobe/lab.key")
    with open(path, encoding="ascii") as file:
        key = bytes.fromhex(file.read().strip())
    if len(key) != 32:
        raise ValueError(f"{path}: not a key of 64 hexadecimal digits")
    return key


def strip_seal(packet):
    """(message, Seal): the packet's parts, whoever sealed it; (packet, None) of one without a seal."""
    if len(packet) < _SEAL.size:
        return packet, None
    magic, fingerprint, sender, number, _ = _SEAL.unpack(packet[-_SEAL.size:])
    if magic != _SEAL_MAGIC:
        return packet, None
    return packet[:-_SEAL.size], Seal(fingerprint.hex(), sender, number)


def is_sealed_with(key, channel, packet):
    """Whether the packet is sealed with the key, for this channel, and unaltered."""
    message, seal = strip_seal(packet)
    if seal is None or seal.fingerprint != hashlib.blake2b(key, digest_size=32).hexdigest()[:8]:
        return False
    name = channel.encode()
    proof = hashlib.blake2b(struct.pack(">qqH", seal.sender, seal.number, len(name)) + name + message,
                            digest_size=16, key=key, person=b"strobe.packet..1")
    return hmac.compare_digest(proof.digest(), packet[-16:])


def packets(path, on_damage=None):
    """Yields (utc_us, channel, packet) of each record. on_damage(offset, size) is told of bytes that are no record."""
    with open(path, "rb") as file:
        at = 0
        while True:
            file.seek(at)
            header = file.read(_HEADER.size)
            body = _body(file, header)
            if body is not None:
                _, _, utc_us, channel_size, _ = _HEADER.unpack(header)
                yield utc_us, body[:channel_size].decode(errors="replace"), body[channel_size:]
                at += len(header) + len(body)
                continue
            found = _find_sync(file, at + 1)
            end = file.seek(0, os.SEEK_END) if found is None else found
            if end > at and on_damage:
                on_damage(at, end - at)
            if found is None:
                return
            at = found


def _body(file, header):
    """Channel and packet behind a header; None if it is none."""
    if len(header) < _HEADER.size:
        return None
    sync, _, _, channel, data = _HEADER.unpack(header)
    if sync != _SYNC or not 0 < channel <= _LONGEST_CHANNEL or not 0 <= data <= _LARGEST_MESSAGE:
        return None
    body = file.read(channel + data)
    return body if len(body) == channel + data else None


def _find_sync(file, at):
    while True:
        file.seek(at)
        part = file.read(_PART)
        found = part.find(_SYNC)
        if found >= 0:
            return at + found
        if len(part) < _PART:
            return None
        at += len(part) - len(_SYNC) + 1  # one may lie across two parts


def read(path, kinds=None, key=None, on_damage=None):
    """Yields a Record of each packet on Strobe's channels, STROBE/<rig>/<KIND>. kinds: only those, {"SHOT", "EVENT"}."""
    for utc_us, channel, packet in packets(path, on_damage):
        kind = channel.rpartition("/")[2]
        if not channel.startswith("STROBE/") or kind not in _TYPES or (kinds and kind not in kinds):
            continue
        encoded, seal = strip_seal(packet)
        verified = None if key is None else is_sealed_with(key, channel, packet)
        yield Record(utc_us, channel, kind, _decode(kind, encoded), seal, verified)


def _decode(kind, encoded):
    for name in [_TYPES[kind], *_FORMER_TYPES.get(kind, [])]:
        message_type = getattr(importlib.import_module("strobe_msgs." + name), name)
        try:
            return message_type.decode(encoded)
        except (ValueError, struct.error, IndexError, UnicodeDecodeError):
            pass
    return None


def columns(messages):
    """The messages' numbers and texts as numpy arrays by name; a plan's fields as "plan.period_ns"; lists left out."""
    import numpy

    rows = [dict(_flat(message)) for message in messages]
    return {name: numpy.array([row[name] for row in rows]) for name in (rows[0] if rows else ())}


def _flat(message, prefix=""):
    for name in message.__slots__:
        value = getattr(message, name)
        if hasattr(value, "__slots__"):
            yield from _flat(value, prefix + name + ".")
        elif not isinstance(value, (list, tuple)):
            yield prefix + name, value
