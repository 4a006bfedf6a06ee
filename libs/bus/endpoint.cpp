#include "bus/endpoint.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>

namespace voxatlas {
namespace {

struct EndpointRange {
  const char* name;
  std::int32_t first;  ///< Port offset of index 0.
  std::int32_t count;
};

/// By EndpointClass.
constexpr std::array<EndpointRange, 4> kRanges{{
    {"INGEST", 100, 100},
    {"STORE", 200, 100},
    {"COMPRESS", 300, 100},
    {"CLIENT", 400, 600},
}};

const EndpointRange& range_of(EndpointClass endpoint_class) {
  return kRanges[static_cast<std::size_t>(endpoint_class)];
}

}  // namespace

Result<Endpoint> Endpoint::create(EndpointClass endpoint_class, std::int32_t index) {
  const auto& range = range_of(endpoint_class);
  if (index < 0 || index >= range.count) {
    return fail(ErrorCode::kOutOfRange, fmt::format("endpoint {} {}: indexes are 0 to {}",
                                                    range.name, index, range.count - 1));
  }
  return Endpoint{endpoint_class, index};
}

Result<Endpoint> Endpoint::client_at(std::int32_t port_offset) {
  const auto& range = range_of(EndpointClass::kClient);
  if (port_offset < range.first || port_offset - range.first >= range.count) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("reply port {}: clients' are {} to {}", port_offset, range.first,
                            range.first + range.count - 1));
  }
  return Endpoint{EndpointClass::kClient, port_offset - range.first};
}

Endpoint Endpoint::for_this_client() {
  return {EndpointClass::kClient, ::getpid() % range_of(EndpointClass::kClient).count};
}

std::int32_t Endpoint::port_offset() const { return range_of(endpoint_class).first + index; }

std::string Endpoint::chunk_channel() const {
  return fmt::format("VOXATLAS_CHUNK_{}_{}", range_of(endpoint_class).name, index);
}

}  // namespace voxatlas
