"""A second decoder of encoded tiles, written from libs/codec/FORMAT.md alone: plain and slow.

`read_tile(bytes)` returns a Tile: 4096 bricks in Morton order, each None (nothing known), one state,
or a list of 512 states in Morton order. A state is (log-odds, colour); a colour is None or
(count, r, g, b) with 8.8 fixed point means. An unknown voxel is None.
"""

import ctypes
import ctypes.util
import hashlib
import struct

SLOTS, VOXELS = 4096, 512
EMPTY, UNIFORM, MIXED, OUTSIDE = 0, 1, 2, 3
FIRST = {4: 0, 5: 1, 6: 9, 7: 73}  # Where a depth's cells begin in a mixed slot's `highest`.


class Corrupt(Exception):
    pass


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def unfold(frame):
    """One Zstandard frame, which states its content's size. Python 3.11 has no Zstandard of its own."""
    zstd = ctypes.CDLL(ctypes.util.find_library("zstd") or "libzstd.so.1")
    zstd.ZSTD_getFrameContentSize.restype = ctypes.c_ulonglong
    zstd.ZSTD_decompress.restype = ctypes.c_size_t
    size = zstd.ZSTD_getFrameContentSize(frame, ctypes.c_size_t(len(frame)))
    if size > 1 << 28:
        raise Corrupt("no Zstandard frame of a stated size")
    content = ctypes.create_string_buffer(size + 1)
    got = zstd.ZSTD_decompress(content, ctypes.c_size_t(size), frame, ctypes.c_size_t(len(frame)))
    if got != size:
        raise Corrupt("a damaged Zstandard frame")
    return content.raw[:size]


class Reader:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, count):
        if self.at + count > len(self.data):
            raise Corrupt("too short")
        self.at += count
        return self.data[self.at - count:self.at]

    def get(self, kind):
        return struct.unpack("<" + kind, self.take(struct.calcsize("<" + kind)))

    def u8(self):
        return self.take(1)[0]

    def varint(self):
        value = shift = 0
        while True:
            byte = self.u8()
            value |= (byte & 127) << shift
            if byte < 128:
                return value
            shift += 7

    def end(self):
        if self.at != len(self.data):
            raise Corrupt("bytes behind the end")


def interleave(x, y, z, bits):
    return sum((x >> k & 1) << 3 * k | (y >> k & 1) << 3 * k + 1 | (z >> k & 1) << 3 * k + 2
               for k in range(bits))


def neighbour(code, axis, step, bits):
    """The Morton code one cell up or down an axis; None outside."""
    place = sum((code >> 3 * k + axis & 1) << k for k in range(bits)) + step
    if not 0 <= place < 1 << bits:
        return None
    for k in range(bits):
        code = code & ~(1 << 3 * k + axis) | (place >> k & 1) << 3 * k + axis
    return code


class Tile:
    def __init__(self):
        self.bricks = [None] * SLOTS

    def leaves(self):
        """(depth, Morton code, state) of the canonical octree, in Morton order."""
        for brick, content in enumerate(self.bricks):
            if isinstance(content, list) and all(state == content[0] for state in content):
                self.bricks[brick] = content[0]
        yield from self._above(0, 0)

    def _above(self, depth, code):
        count = 8 ** (4 - depth)
        bricks = self.bricks[code * count:(code + 1) * count]
        if isinstance(bricks[0], list) and depth == 4:
            yield from self._inside(bricks[0], 4, code, 0, VOXELS)
        elif not isinstance(bricks[0], list) and all(other == bricks[0] for other in bricks):
            if bricks[0] is not None:
                yield depth, code, bricks[0]
        else:
            for octant in range(8):
                yield from self._above(depth + 1, 8 * code + octant)

    def _inside(self, voxels, depth, code, first, count):
        own = voxels[first:first + count]
        if all(state == own[0] for state in own):
            if own[0] is not None:
                yield depth, code, own[0]
            return
        for octant in range(8):
            yield from self._inside(voxels, depth + 1, 8 * code + octant,
                                    first + octant * count // 8, count // 8)

    def hash(self, key=0):
        """libs/octree/FORMAT.md, `tile_hash`."""
        digest = hashlib.sha256(struct.pack("<Q", key))
        for depth, code, (log_odds, colour) in self.leaves():
            digest.update(struct.pack("<BIhB", depth, code, log_odds, colour[0] if colour else 0))
            if colour:
                digest.update(struct.pack("<3H", *colour[1:]))
        return digest.hexdigest()


def read_tile(data):
    magic, version, codec = struct.unpack_from("<4sBB", data)
    if magic != b"VXTL" or version not in (1, 2):
        raise Corrupt("no tile of version 1 or 2")
    at = 10 if version == 1 else 6
    if struct.unpack_from("<I", data, at)[0] != crc32c(data[:at] + data[at + 4:]):
        raise Corrupt("the checksum")
    payload = data[at + 4:]
    if version == 1:
        return NodeStream(unfold(payload)).tile
    if codec == 1:
        return read_fast(payload)
    return Dense(payload[6:] if codec == 3 else payload).tile


# --- fast ---

def places(reader, count, palette):
    low = reader.take(count)
    high = reader.take(count) if len(palette) > 255 else bytes(count)
    return [a | b << 8 for a, b in zip(low, high)]


def get_colour(reader):
    return reader.get("B3H")


def read_fast(payload):
    reader = Reader(payload)
    head_size, body_size, frame_size = reader.varint(), reader.varint(), reader.varint()
    head = Reader(unfold(reader.take(frame_size)) if head_size else b"")
    body = Reader(unfold(payload[reader.at:]) if body_size else b"")
    tile = Tile()
    if not head_size:
        return tile
    palette = [head.get("h")[0] for _ in range(head.varint())]
    value = [None] + [(log_odds, None) for log_odds in palette]  # By place.
    kinds = head.take(SLOTS)
    ground = places(head, sum(kind != EMPTY for kind in kinds), palette)
    places(head, kinds.count(MIXED), palette)  # The highest: only for readers of the head alone.
    mixed = [slot for slot in range(SLOTS) if kinds[slot] == MIXED]
    masks = [int.from_bytes(body.take(64), "little") for _ in mixed]
    coded = iter(places(body, sum(mask.bit_count() for mask in masks), palette))
    grounds, masks = iter(ground), iter(masks)
    for slot, kind in enumerate(kinds):
        if kind == UNIFORM:
            tile.bricks[slot] = value[next(grounds)]
        elif kind == MIXED:
            own, mask = next(grounds), next(masks)
            tile.bricks[slot] = [value[next(coded) if mask >> i & 1 else own]
                                 for i in range(VOXELS)]
    slot = -1
    coloured = []
    for _ in range(head.varint()):
        left_out, count = head.get("HH")
        slot += 1 + (left_out & 0x7FFF)
        coloured.append((slot, left_out & 0x8000, get_colour(head)))
    for slot, alike, mean in coloured:
        if alike:
            tile.bricks[slot] = (tile.bricks[slot][0], mean)
            continue
        rows = body.get("8Q")
        if not isinstance(tile.bricks[slot], list):
            tile.bricks[slot] = [tile.bricks[slot]] * VOXELS
        for z in range(8):
            for bit in range(64):
                if rows[z] >> bit & 1:
                    voxel = interleave(bit & 7, bit >> 3, z, 3)
                    state = tile.bricks[slot][voxel]
                    tile.bricks[slot][voxel] = (state[0], get_colour(body))
    head.end()
    body.end()
    return tile


# --- dense ---

class Slot:
    def __init__(self):
        self.kind, self.ground, self.highest = EMPTY, 0, 0
        self.cells = None  # Of a mixed slot: highest places of its cells of depth 4..7.
        self.exception = None  # And whether each is an exception.


NOWHERE = Slot()
NOWHERE.kind = OUTSIDE


class Dense:
    """One dense payload. `trace`, if given, is called with each question, its chance and answer."""

    def __init__(self, payload, trace=None):
        self.tile, self.trace = Tile(), trace
        if not payload:
            return
        self.payload, self.at, self.chances = payload, 0, {}
        self.range, self.code = 0xFFFFFFFF, 0
        for _ in range(4):
            self.code = self.code << 8 | self.byte()
        self.palette = self.read_palette()
        self.tree_bits = (len(self.palette) - 1).bit_length()
        self.slots = [Slot() for _ in range(SLOTS)]
        for number in range(SLOTS):
            self.read_slot(number)
        self.coloured = self.read_brick_colours()
        for depth in (5, 6, 7):
            for number, slot in enumerate(self.slots):
                if slot.kind == MIXED:
                    self.read_depth(number, slot, depth)
        self.make_bricks()
        self.read_voxel_colours()
        if not 0 <= self.at - len(payload) <= 4:
            raise Corrupt("the end is elsewhere")

    def byte(self):
        self.at += 1
        return self.payload[self.at - 1] if self.at <= len(self.payload) else 0

    def bit(self, *chance):
        p, n = self.chances.get(chance, (32768, 0))
        ones = (self.range >> 16) * p
        bit = self.code < ones
        if bit:
            self.range = ones
        else:
            self.code -= ones
            self.range -= ones
        self.chances[chance] = (p + (((65504 if bit else 32) - p) * (327680 // (5 * n + 8)) >> 16),
                                min(n + 1, 38))
        while self.range < 1 << 24:
            self.range <<= 8
            self.code = self.code << 8 | self.byte()
        if self.trace:
            self.trace(chance, p, bit)
        return bit

    def number(self, bits, *tree):
        node = 1
        for _ in range(bits):
            node = 2 * node + self.bit(*tree, node)
        return node - (1 << bits)

    def read_palette(self):
        zero = self.bit("value", False)
        palette, asked, queue = [0] if zero else [], {0}, [(0, zero)]
        for value, there in queue:
            for step in (3471, -1661):
                after = min(max(value + step, -8161), 14238)
                if after in asked:
                    continue
                asked.add(after)
                is_there = self.bit("value", not there)
                if is_there:
                    palette.append(after)
                if is_there or there:
                    queue.append((after, is_there))
        while self.bit("another value"):
            value = 0
            for k in range(15, -1, -1):
                value = 2 * value + self.bit("bit of a value", k)
            palette.append(value - 32768)
        return sorted(palette)

    def place(self, tree):
        place = self.number(self.tree_bits, "tree", tree) + 1
        if place > len(self.palette):
            raise Corrupt("a place beyond the palette")
        return place

    def occupied(self, place):
        return place > 0 and self.palette[place - 1] >= 0

    def slot_beside(self, number, axis, step):
        there = neighbour(number, axis, step, 4)
        return NOWHERE if there is None else self.slots[there]

    def read_slot(self, number):
        slot = self.slots[number]
        lower = [self.slot_beside(number, axis, -1) for axis in range(3)]
        kinds = tuple(there.kind for there in lower)
        if self.bit("empty", kinds):
            return
        mixed = self.bit("mixed", kinds)
        slot.kind = MIXED if mixed else UNIFORM
        slot.ground = slot.highest = self.read_ground([there.ground for there in lower], mixed)
        if not mixed:
            return
        beside = [there for there in lower if there.kind == MIXED]
        top = len(self.palette)
        at_top = sum(there.highest == top for there in beside)
        bare = slot.ground == 0
        slot.highest = (top if self.bit("top", bare, len(beside), at_top)
                        else self.place(3 if bare else 2))
        slot.cells = [slot.ground] * (1 + 8 + 64 + 512)
        slot.cells[0] = slot.highest
        slot.exception = [True] + [False] * (8 + 64 + 512)

    def read_ground(self, lower, mixed):
        if mixed and self.bit("ground unknown", tuple(place == 0 for place in lower)):
            return 0
        alike = (lower[0] == lower[1], lower[1] == lower[2], lower[2] == lower[0])
        asked = []
        for place in lower:
            if place == 0 or place in asked:
                continue
            if self.bit("same ground", mixed, len(asked), alike):
                return place
            asked.append(place)
        return self.place(1 if mixed else 0)

    def cell_beside(self, number, depth, cell, axis, step):
        """(slot, cell) of the next cell of a depth along an axis, or None where no mixed slot is."""
        bits = depth - 4
        there = neighbour(cell, axis, step, bits) if bits else None
        if there is not None:
            return self.slots[number], there
        slot = self.slot_beside(number, axis, step)
        if slot.kind != MIXED:
            return None
        edge = (1 << bits) - 1 if step < 0 else 0
        for k in range(bits):
            cell = cell & ~(1 << 3 * k + axis) | (edge >> k & 1) << 3 * k + axis
        return slot, cell

    def read_depth(self, number, slot, depth):
        for parent in range(8 ** (depth - 5)):
            if slot.exception[FIRST[depth - 1] + parent]:
                self.read_family(number, slot, depth, parent)

    def read_family(self, number, slot, depth, parent):
        def parent_is_exception(axis, step):
            there = self.cell_beside(number, depth - 1, parent, axis, step)
            return there is not None and there[0].exception[FIRST[depth - 1] + there[1]]

        def lower(octant, axis):
            """Slot and index of the neighbour one lower at this depth, if it is an exception."""
            there = self.cell_beside(number, depth, 8 * parent + octant, axis, -1)
            if there is None or not there[0].exception[FIRST[depth] + there[1]]:
                return None
            return there[0], FIRST[depth] + there[1]

        def view(octant, axis):
            if octant >> axis & 1:
                return 3 + 2 * (lower(octant, axis) is not None) + parent_is_exception(axis, 1)
            if lower(octant, axis) is not None:
                return 2
            return int(parent_is_exception(axis, -1))

        bare = slot.ground == 0
        first = FIRST[depth] + 8 * parent
        before = 0
        for octant in range(8):
            one = True
            if octant < 7 or before:
                views = tuple(sorted(view(octant, axis) for axis in range(3)))
                one = self.bit("exception", depth, bare, min(before, 3), views)
            slot.exception[first + octant] = one
            before += one
        own = [octant for octant in range(8) if slot.exception[first + octant]]
        self.read_highest(slot, depth, own, first, slot.cells[FIRST[depth - 1] + parent], lower)

    def read_highest(self, slot, depth, own, first, most, lower):
        most_class = 2 if most == len(self.palette) else 1 if self.occupied(most) else 0
        ground_class = min(slot.ground, 2)
        reached = len(own) < 8 and slot.ground == most
        last = None
        for left, octant in zip(range(len(own) - 1, -1, -1), own):
            is_most = left == 0 and not reached
            if not is_most and not (depth == 7 and slot.ground == most):
                beside = [there for axis in range(3) if (there := lower(octant, axis))]
                high = sum(where.cells[at] >= most for where, at in beside)
                is_most = self.bit("most", depth, most_class, left, reached, len(beside), high)
            if is_most:
                slot.cells[first + octant] = most
                reached = True
                continue
            if slot.ground and self.bit("unknown", depth, ground_class):
                place = 0
            elif last and self.bit("as the last", depth, most_class, ground_class):
                place = last
            else:
                place = last = self.place(4 + 9 * (depth - 5) + 3 * most_class + ground_class)
            if place >= most:
                raise Corrupt("higher than the highest")
            slot.cells[first + octant] = place
        if not reached:
            raise Corrupt("nobody is the highest")

    def make_bricks(self):
        value = [None] + [(log_odds, None) for log_odds in self.palette]
        for number, slot in enumerate(self.slots):
            if slot.kind == UNIFORM:
                self.tile.bricks[number] = value[slot.ground]
            elif slot.kind == MIXED:
                self.tile.bricks[number] = [value[place] for place in slot.cells[FIRST[7]:]]

    def read_brick_colours(self):
        if not self.bit("any colour"):
            return []
        coloured, had, before = [], False, (0, 0, 0, 0)
        for number, slot in enumerate(self.slots):
            if not self.occupied(slot.highest):
                continue
            had = self.bit("brick coloured", had)
            if not had:
                continue
            alike = slot.kind == UNIFORM and self.bit("alike")
            before = self.read_colour("brick", before)
            voxels = VOXELS
            if not alike:
                voxels = 1 + (256 if self.bit("many") else 0)
                voxels += self.number(8, "voxels")
            coloured.append((number, alike, before, voxels))
        return coloured

    def read_voxel_colours(self):
        for number, alike, mean, left in self.coloured:
            brick = self.tile.bricks[number]
            if alike:
                self.tile.bricks[number] = (brick[0], mean)
                continue
            if not isinstance(brick, list):
                brick = self.tile.bricks[number] = [brick] * VOXELS
            had, last = True, mean
            for voxel in range(VOXELS):
                if left == 0:
                    break
                if brick[voxel] is None or brick[voxel][0] < 0:
                    continue
                had = self.bit("voxel coloured", had)
                if not had:
                    continue
                if not self.bit("as the last colour"):
                    last = self.read_colour("voxel", last)
                brick[voxel] = (brick[voxel][0], last)
                left -= 1

    def read_colour(self, whose, before):
        count = self.number(4, whose, "count") + 1
        means, shift = [], 0
        for channel in range(3):
            was = before[1 + channel] >> 8
            high = (was + shift + self.number(8, whose, "high", channel)) & 255
            low = self.number(8, whose, "low", channel, count == 1)
            means.append(high << 8 | low)
            shift = high - was
        return count, *means


# --- version 1 ---

class NodeStream:
    def __init__(self, data):
        self.tile, self.cells = Tile(), []
        reader = Reader(data)
        root = reader.u8()
        if root == 0:
            return reader.end()
        if root == 1:
            self.cells.append((0, 0))
        else:
            inner, leaf_masks = reader.varint(), reader.varint()
            self.children, self.leaves = Reader(reader.take(inner)), Reader(reader.take(leaf_masks))
            self.read_inner(0, 0)
            self.children.end()
            self.leaves.end()
        self.read_states(reader)
        reader.end()

    def read_inner(self, depth, code):
        children = self.children.u8()
        leaves = children if depth == 6 else self.leaves.u8()
        for octant in range(8):
            if leaves >> octant & 1:
                self.cells.append((depth + 1, 8 * code + octant))
            elif children >> octant & 1:
                self.read_inner(depth + 1, 8 * code + octant)

    def read_states(self, reader):
        palette = reader.get(f"{reader.varint()}h")
        index = reader.take(len(self.cells))
        high = reader.take(len(self.cells)) if len(palette) > 256 else bytes(len(self.cells))
        log_odds = [palette[a | b << 8] for a, b in zip(index, high)]
        colours = [None] * len(self.cells)
        count = reader.varint()
        if count:
            occupied = [i for i, value in enumerate(log_odds) if value >= 0]
            flags = int.from_bytes(reader.take((len(occupied) + 7) // 8), "little")
            coloured = [i for n, i in enumerate(occupied) if flags >> n & 1]
            counts = reader.take(count)
            high, low = reader.take(3 * count), reader.take(3 * count)
            for n, i in enumerate(coloured):
                colours[i] = (counts[n], *(high[n + c * count] << 8 | low[n + c * count]
                                           for c in range(3)))
        for cell, value, colour in zip(self.cells, log_odds, colours):
            self.put(*cell, (value, colour))

    def put(self, depth, code, state):
        bricks = self.tile.bricks
        if depth <= 4:
            first, count = code << 3 * (4 - depth), 8 ** (4 - depth)
            bricks[first:first + count] = [state] * count
            return
        brick, count = code >> 3 * (depth - 4), 8 ** (7 - depth)
        if bricks[brick] is None:
            bricks[brick] = [None] * VOXELS
        first = (code & 8 ** (depth - 4) - 1) * count
        bricks[brick][first:first + count] = [state] * count
