#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/result.hpp"
#include "hub/hub_service.hpp"

namespace voxatlas {

/// A HubService at a TCP port. One thread, one poll() loop; no socket ever blocks.
class HubServer {
 public:
  /// Port 0: a free one. Errors: kIo where the address cannot be listened on, naming it.
  static Result<std::unique_ptr<HubServer>> listen(const std::string& address, std::int32_t port,
                                                   const HubConfig& config);
  ~HubServer();

  std::int32_t port() const;
  /// Waits until something happens, at most so long, and does it. Errors: kIo: it cannot go on.
  Status serve(int wait_ms);
  HubService& service();

 private:
  struct State;
  explicit HubServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace voxatlas
