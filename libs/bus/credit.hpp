#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace voxatlas {

/// What one producer may send, as its consumer keeps the books.
struct CreditAccount {
  std::int64_t credit = 0;        ///< Chunks below this are granted.
  std::int64_t accept_below = 0;  ///< The most ever granted: what may still come late.
  std::int64_t told_at = 0;       ///< When an acknowledgement last named the credit.
  std::int64_t granted_at = 0;    ///< When it was last granted some,
  std::uint64_t turn = 0;         ///< and in which turn.
  std::size_t chunk_bytes = 0;    ///< Data of a full chunk; 0: none seen yet.

  // As of now, from the stream:
  std::int64_t arrived = 0;  ///< Chunks that have.
  std::int64_t offered = 0;  ///< Chunks the producer has.
  std::int64_t heard_at = 0;
  bool granted = false;  ///< Set where divide() gave some that was waited for: to be told at once.

  std::int64_t outstanding() const { return credit > arrived ? credit - arrived : 0; }
};

/// What a datagram of so many bytes of data takes of the receive buffer: the kernel counts whole
/// pages and its own books. Three of 60 kB fit the default of 208 kB. 0: not known yet, the most.
std::size_t buffer_cost(std::size_t chunk_bytes);

/// Divides the receive buffer among those who want to send: the one whose turn is longest ago
/// first, to each its share, at least a chunk; what is left over goes ahead to those who lately
/// sent, so that they need not ask. Who let a turn pass in silence gets no other until it is heard.
void divide_credit(std::span<CreditAccount*> accounts, std::size_t receive_buffer_bytes,
                   std::int64_t now, std::uint64_t& turns);

/// How long told credit counts; a producer stops using it earlier (StreamProducer).
inline constexpr std::int64_t kCreditCountsUs = 150'000;

/// Takes back credit that was told longer ago than that.
void lapse_credit(CreditAccount& account, std::int64_t now);

}  // namespace voxatlas
