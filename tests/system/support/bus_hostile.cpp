// An enemy on the bus: sends without end, on every channel and to every port, until it gets
// SIGTERM: random bytes; a type's fingerprint and random bytes; messages of each type with hostile
// numbers in them; datagrams that are not even LCM's. Prints how many of each when it ends.
//
//   bus_hostile URL SHARDS INGESTS SEED
#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <memory>
#include <random>
#include <stdexcept>
#include <thread>

#include "base/utime.hpp"
#include "bus/bus.hpp"
#include "bus/bus_url.hpp"
#include "bus/channels.hpp"
#include "bus/checksum.hpp"
#include "bus/endpoint.hpp"
#include "bus/service_loop.hpp"
#include "unit/bus/random_messages.hpp"

namespace voxatlas {
namespace {

template <class T>
T or_throw(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

class Enemy {
 public:
  Enemy(const std::string& url, std::int32_t shards, std::int32_t ingests, std::uint64_t seed)
      : url_(url), rng_(seed), messages_(rng_) {
    buses_.push_back(or_throw(Bus::create(url)));
    listen_to(EndpointClass::kStore, shards);
    listen_to(EndpointClass::kIngest, ingests);
    listen_to(EndpointClass::kCompress, 1);
    listen_to(EndpointClass::kClient, 1);
  }

  void strike() {
    auto& main = *buses_.front();
    on<ack_t>(main, kAckChannel);
    on<status_t>(main, kStatusChannel);
    on<tile_update_t>(main, kTileUpdateChannel);
    on<frame_t>(main, kFrameChannel);
    on<render_request_t>(main, kRenderRequestChannel);
    on<model_request_t>(main, kModelRequestChannel);
    on<tiles_request_t>(main, kTilesRequestChannel);
    on<tile_request_t>(main, kTileRequestChannel);
    on<scan_t>(main, kScanChannel);
    for (std::size_t i = 1; i < buses_.size(); ++i) {
      on<chunk_t>(*buses_[i], channels_[i - 1]);
      on<model_reply_t>(*buses_[i], kModelReplyChannel);
      on<tiles_reply_t>(*buses_[i], kTilesReplyChannel);
      on<tile_reply_t>(*buses_[i], kTileReplyChannel);
    }
    if (rng_() % 4 == 0) throw_datagram();
  }

  void report() const {
    fmt::print("noise {} fingerprinted {} stamped {} sound {} datagrams {}\n", counts_[0],
               counts_[1], counts_[2], counts_[3], datagrams_);
  }

 private:
  void listen_to(EndpointClass kind, std::int32_t count) {
    for (std::int32_t i = 0; i < count; ++i) {
      const auto endpoint = or_throw(Endpoint::create(kind, i));
      buses_.push_back(or_throw(Bus::create(or_throw(url_at_port(url_, endpoint.port_offset())))));
      channels_.push_back(endpoint.chunk_channel());
    }
  }

  /// One message on the channel that is meant for messages of type T. A scan is never left sound:
  /// that would be a logger's, and rightly change the model.
  template <class T>
  void on(Bus& bus, const std::string& channel) {
    auto message = messages_.make<T>();
    if constexpr (std::is_same_v<T, ack_t> || std::is_same_v<T, chunk_t>) {
      message.crc = checksum(message);  // Where nothing is changed below, only a liar is left.
    }
    auto bytes = encode_message(message);
    const auto how = rng_() % (std::is_same_v<T, scan_t> ? 3 : 4);
    if (how == 0) bytes.resize(rng_() % 3000);
    if (how < 2) {
      for (std::size_t i = how * 8; i < bytes.size(); ++i) {
        bytes[i] = static_cast<std::uint8_t>(rng_());
      }
    }
    if (how == 2) stamp(bytes);
    if (how == 2 && std::is_same_v<T, scan_t> && decode_message<T>(bytes)) return;
    ++counts_[how];
    (void)bus.publish_bytes(channel, bytes);
  }

  /// Hostile counts, wherever one may stand.
  void stamp(Bytes& bytes) {
    constexpr std::array<std::uint32_t, 6> kHostile{0,          1,          0x7fffffff,
                                                    0x80000000, 0xffffffff, 0xfffffff0};
    for (auto times = 1 + rng_() % 4; times > 0 && bytes.size() >= 12; --times) {
      const auto at = 8 + rng_() % (bytes.size() - 11);
      const auto value = kHostile[rng_() % kHostile.size()];
      for (std::size_t i = 0; i < 4; ++i) {
        bytes[at + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
      }
    }
  }

  /// Below LCM: its magic number or not, fragments that lead nowhere, names without an end.
  void throw_datagram() {
    const auto parsed = or_throw(BusUrl::parse(url_));
    if (!parsed.is_multicast()) return;
    if (socket_ < 0) socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(kPort + (rng_() % 2 == 0 ? 0 : 200)));
    ::inet_pton(AF_INET, kGroup, &to.sin_addr);
    const unsigned char ttl = 0;
    ::setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
    Bytes bytes(rng_() % 2000);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng_());
    constexpr std::array<std::uint8_t, 3> kMagic{'L', 'C', '0'};
    if (bytes.size() > 4 && rng_() % 4 != 0) {
      std::ranges::copy(kMagic, bytes.begin());
      bytes[3] = static_cast<std::uint8_t>('2' + rng_() % 2);  // A short message, or a fragment.
    }
    if (::sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to),
                 sizeof to) >= 0) {
      ++datagrams_;
    }
  }

  static constexpr const char* kGroup = "239.255.76.67";
  static constexpr int kPort = 7667;

  std::string url_;
  std::mt19937_64 rng_;
  test::RandomMessages messages_;
  std::vector<std::unique_ptr<Bus>> buses_;  ///< The bus, then a port of each consumer.
  std::vector<std::string> channels_;        ///< Of the consumers.
  std::array<std::uint64_t, 4> counts_{};
  std::uint64_t datagrams_ = 0;
  int socket_ = -1;
};

}  // namespace
}  // namespace voxatlas

int main(int argc, char** argv) {
  using namespace voxatlas;
  if (argc != 5) {
    fmt::print(stderr, "usage: bus_hostile URL SHARDS INGESTS SEED\n");
    return 2;
  }
  try {
    stop_on_signals();
    Enemy enemy(argv[1], std::stoi(argv[2]), std::stoi(argv[3]), std::stoull(argv[4]));
    while (!stop_requested()) {
      enemy.strike();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));  // The bus is to carry scans, too.
    }
    enemy.report();
  } catch (const std::exception& e) {
    fmt::print(stderr, "bus_hostile: {}\n", e.what());
    return 1;
  }
}
