"""SBF blocks for the oracle tests: taken from a log, put together again. Knows the framing, nothing of the contents."""

import binascii
import struct

MEAS_EPOCH = 4027


def blocks(data):
    """Yields the valid blocks of a log as bytes."""
    at = data.find(b"$@")
    while at >= 0:
        step = 1
        if at + 8 <= len(data):
            crc, _, length = struct.unpack_from("<HHH", data, at + 2)
            block = data[at : at + length]
            if (
                length >= 8
                and length % 4 == 0
                and length == len(block)
                and binascii.crc_hqx(block[4:], 0) == crc
            ):
                yield block
                step = length
        at = data.find(b"$@", at + step)


def block_id(block):
    return struct.unpack_from("<H", block, 4)[0] & 0x1FFF


def stamp_ms(block):
    """GPS time of the block's stamp in milliseconds."""
    tow, week = struct.unpack_from("<IH", block, 8)
    return week * 604800000 + tow


def seal(block):
    """The block with the CRC that its bytes ask for."""
    return block[:2] + struct.pack("<H", binascii.crc_hqx(block[4:], 0)) + block[4:]


def build(number, revision, tow_ms, week, body):
    """A block of its own from what follows the stamp; padded with zeros to a multiple of four bytes."""
    body += bytes(-(14 + len(body)) % 4)
    head = struct.pack("<2sHHHIH", b"$@", 0, number | revision << 13, 14 + len(body), tow_ms, week)
    return seal(head + body)
