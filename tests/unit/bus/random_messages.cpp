#include "bus/random_messages.hpp"

namespace voxatlas::test {

Bytes RandomMessages::blob(std::size_t size) {
  Bytes bytes(size);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng_());
  return bytes;
}

void RandomMessages::fill(ack_t& m) {
  m.session = number();
  m.incarnation = number();
  m.committed = small();
  m.received = m.committed + small();
  m.credit = m.received + small();
  std::vector<ChunkRange> ranges;
  auto first = m.received;
  for (auto i = below(10); i > 0; --i) {
    ranges.push_back({first, first + 1 + small()});
    first = ranges.back().end + 1;
  }
  set_ranges(m, ranges);
  m.crc = small();
}

void RandomMessages::fill(camera_t& m) {
  m.projection = below<std::int8_t>(2);
  for (auto& c : m.position) c = real();
  for (auto& c : m.orientation) c = real();
  m.fx = real();
  m.fy = real();
  m.cx = real();
  m.cy = real();
  m.width = small();
  m.height = small();
  m.near_range = real();
  m.far_range = real();
}

void RandomMessages::fill(chunk_t& m) {
  m.session = number();
  m.base = small();
  m.count = 1 + small();
  m.index = below(static_cast<std::uint64_t>(m.count));
  m.seq = m.base + m.index + small();
  m.offered = m.seq + 1 + small();
  m.message = number();
  m.kind = below<std::int16_t>(6);
  m.crc = small();
  payload(m.size, m.data);
}

void RandomMessages::fill(counter_t& m) {
  m.name = text();
  m.value = real();
}

void RandomMessages::fill(frame_t& m) {
  m.utime = number();
  m.client = number();
  m.id = number();
  m.renderer = small();
  m.sequence = number();
  m.place = small();
  m.final = below<std::int8_t>(2);
  m.last = below<std::int8_t>(2);
  fill(m.camera);
  m.depth = below<std::int8_t>(8);
  m.samples = below<std::int8_t>(5);
  m.tiles = small();
  m.tiles_missing = small();
  for (auto* count : {&m.newest_version, &m.shown_until, &m.cells}) *count = number();
  m.over_budget = small();
  for (auto* value : {&m.threshold, &m.wait_ms, &m.fetch_ms, &m.draw_ms, &m.shade_ms, &m.overlay_ms,
                      &m.encode_ms, &m.depth_scale}) {
    *value = real();
  }
  m.format = below<std::int8_t>(3);
  m.quality = below<std::int8_t>(100);
  payload(m.size, m.data);
  m.depth_format = below<std::int8_t>(3);
  if (m.depth_format != 0) payload(m.depth_size, m.depth_data);
  if (m.size == 0 && m.depth_size == 0) m.error = text();
}

void RandomMessages::fill(checkpoint_reply_t& m) {
  m.utime = number();
  m.client = number();
  m.id = number();
  m.shard = small();
  auto& told = below<int>(2) == 0 ? m.folder : m.error;
  told = text();
  told.push_back('x');
}

void RandomMessages::fill(checkpoint_request_t& m) {
  m.utime = number();
  m.client = number();
  m.id = number();
  m.deadline = number();
  m.reply_port = small();
  m.shard = small();
}

void RandomMessages::fill(model_reply_t& m) {
  m.utime = number();
  m.client = number();
  m.id = number();
  m.shard = small();
  m.epoch = number();
  m.mark = small() - 1;
  m.holder = number();
  m.disk_bytes = number();
  payload(m.size, m.parameters);
}

void RandomMessages::fill(model_request_t& m) {
  m.utime = number();
  m.client = number();
  m.id = number();
  m.deadline = number();
  m.reply_port = small();
  m.shard = small();
  m.source = text();
  m.session = number();
  m.claim = below<std::int8_t>(3);
  m.acked_below = small();
}

void RandomMessages::fill(render_request_t& m) {
  m.utime = number();
  m.client = number();
  m.id = number();
  m.deadline = number();
  m.kind = below<std::int8_t>(3);
  fill(m.camera);
  m.rate = real();
  m.first = small();
  m.path = blob(64 * below<std::size_t>(5));
  m.path_size = static_cast<std::int32_t>(m.path.size());
  m.budget_ms = real();
  m.depth = below<std::int8_t>(8);
  m.colouring = text();
  m.free_depth = below<std::int8_t>(8);
  m.overlay = below<std::int8_t>(16);
  m.fill_holes = below<std::int8_t>(2);
  m.backend = below<std::int8_t>(2);
  m.format = below<std::int8_t>(3);
  m.depth_format = below<std::int8_t>(3);
  m.reply_port = small();
}

void RandomMessages::fill(scan_delta_t& m) {
  m.utime = number();
  m.source = source();
  m.session = number();
  m.seq = number();
  m.acked_below = number();
  m.parameters = number();
  m.shard = below(10);
  m.shards = m.shard + 1 + below(10);
  m.tiles = below(6);
  ByteWriter writer(m.data);
  std::uint64_t key = 0;
  for (std::int32_t i = 0; i < m.tiles; ++i) {
    const auto delta = blob(below<std::size_t>(50));
    writer.put(key += 1 + below<std::uint64_t>(1000));
    writer.put(static_cast<std::uint32_t>(delta.size()));
    writer.put_bytes(delta);
  }
  m.size = static_cast<std::int32_t>(m.data.size());
}

void RandomMessages::fill(scan_t& m) {
  m.utime = number();
  m.source = source();
  m.session = number();
  m.seq = number();
  m.parts = static_cast<std::int16_t>(1 + below(64));
  m.part = below<std::int16_t>(static_cast<std::uint64_t>(m.parts));
  m.sigma = real();
  m.min_range = real();
  for (auto& c : m.ecef_from_sensor) c = real();
  m.coloured = below<std::int8_t>(2);
  m.count = below(30);
  m.size = m.count * (m.coloured != 0 ? 15 : 12);
  m.points = blob(static_cast<std::size_t>(m.size));
}

void RandomMessages::fill(status_t& m) {
  m.utime = number();
  m.service = text();
  m.index = small();
  m.instance = number();
  m.pid = small();
  m.version = text();
  m.ready = below<std::int8_t>(2);
  m.state = text();
  m.counters_count = below(6);
  m.counters.resize(static_cast<std::size_t>(m.counters_count));
  for (auto& counter : m.counters) fill(counter);
}

void RandomMessages::fill(tile_encoded_t& m) {
  m.utime = number();
  m.tile = number();
  m.version = number();
  payload(m.size, m.payload);
}

void RandomMessages::fill(tile_raw_t& m) {
  m.utime = number();
  m.tile = number();
  m.version = number();
  m.shard = small();
  m.clamp_min = static_cast<std::int16_t>(-1 - small() % 9'000);
  m.clamp_max = static_cast<std::int16_t>(small() % 15'000);
  payload(m.size, m.payload);
}

void RandomMessages::fill(tile_reply_t& m) {
  m.utime = number();
  m.client = number();
  m.id = number();
  m.tile = number();
  m.version = number();
  m.offset = small();
  payload(m.size, m.payload);
  m.total = m.offset + m.size + small();
}

void RandomMessages::fill(tile_request_t& m) {
  m.utime = number();
  m.client = number();
  m.id = number();
  m.deadline = number();
  m.reply_port = small();
  m.shard = small();
  m.tile = number();
  m.offset = small();
  m.depth = static_cast<std::int8_t>(small() % 8);
}

void RandomMessages::fill(tile_update_t& m) {
  m.utime = number();
  m.tile = number();
  m.version = number();
  m.shard = small();
  m.content = below<std::int8_t>(3);
  if (m.content != 0) payload(m.size, m.payload);
}

void RandomMessages::fill(tiles_reply_t& m) {
  m.utime = number();
  m.client = number();
  m.id = number();
  m.shard = small();
  m.next = small() - 1;
  m.details = below<std::int8_t>(2);
  m.tiles = below(8);
  m.size = m.tiles * (m.details != 0 ? 80 : 16);
  m.rows = blob(static_cast<std::size_t>(m.size));
}

void RandomMessages::fill(tiles_request_t& m) {
  m.utime = number();
  m.client = number();
  m.id = number();
  m.deadline = number();
  m.reply_port = small();
  m.shard = small();
  m.from = number();
  for (auto& i : m.min_index) i = small();
  for (auto& i : m.max_index) i = small();
  m.details = below<std::int8_t>(2);
}

}  // namespace voxatlas::test
