#pragma once

#include <cstdint>
#include <string>

#include "base/result.hpp"

namespace voxatlas {

/// Who consumes reliable streams. Every instance has its own channel and, on multicast, its own
/// port, because each subscriber of a port receives all its bytes: only so is its credit true.
enum class EndpointClass { kIngest, kStore, kCompress, kClient };

/// One consumer: its class and index. Ports are the bus's port plus an offset: ingests from 100,
/// stores from 200, compressors from 300 (100 each), clients (renderers, command lines) from 400
/// (600).
struct Endpoint {
  EndpointClass endpoint_class = EndpointClass::kIngest;
  std::int32_t index = 0;

  /// Errors: kOutOfRange for an index the class has no port for.
  static Result<Endpoint> create(EndpointClass endpoint_class, std::int32_t index);
  /// A client's endpoint from the offset a request carries. Errors: kOutOfRange if it is no
  /// client's.
  static Result<Endpoint> client_at(std::int32_t port_offset);
  /// A client's endpoint drawn from the process id, so that clients seldom share one; sharing costs
  /// bytes, never correctness: streams and replies are told apart by session and client.
  static Endpoint for_this_client();

  std::int32_t port_offset() const;
  std::string chunk_channel() const;  ///< "VOXATLAS_CHUNK_STORE_0" and so on.

  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

/// The URL of an endpoint's own port: the bus's with the port moved by `offset` (udpm); the same
/// URL for providers without ports (tcpq, memq). Errors: kInvalid for a URL that cannot be read.
Result<std::string> url_at_port(const std::string& url, std::int32_t offset);

}  // namespace voxatlas
