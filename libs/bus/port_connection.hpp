#pragma once

#include <memory>

#include "base/result.hpp"
#include "bus/bus.hpp"
#include "bus/endpoint.hpp"

namespace voxatlas {

/// The connection to an endpoint's port: one of its own where the bus has ports (multicast), the
/// bus itself where it has none. The bus must outlive it.
class PortConnection {
 public:
  static Result<PortConnection> open(Bus& bus, const Endpoint& endpoint) {
    if (!bus.has_ports()) return PortConnection(bus, nullptr);
    auto url = url_at_port(bus.url(), endpoint.port_offset());
    if (!url) return pass_on(url);
    auto own = Bus::create_port(*url);
    if (!own) return pass_on(own, endpoint.chunk_channel());
    auto& opened = **own;
    return PortConnection(opened, std::move(*own));
  }

  Bus& bus() const { return *bus_; }

 private:
  PortConnection(Bus& bus, std::unique_ptr<Bus> own) : own_(std::move(own)), bus_(&bus) {}

  std::unique_ptr<Bus> own_;
  Bus* bus_;
};

}  // namespace voxatlas
