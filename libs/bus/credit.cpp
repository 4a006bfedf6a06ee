#include "bus/credit.hpp"

#include <algorithm>
#include <vector>

namespace voxatlas {
namespace {

constexpr std::size_t kPage = 4096;
constexpr std::size_t kUnknownChunkBytes = 60'000;
constexpr std::int64_t kLatelyUs = 50'000;

bool wants_more(const CreditAccount& account) {
  return account.offered > account.credit && account.heard_at >= account.granted_at;
}

std::size_t cost_of(const CreditAccount& account) { return buffer_cost(account.chunk_bytes); }

void grant(CreditAccount& account, std::int64_t chunks) {
  account.credit += chunks;
  account.accept_below = std::max(account.accept_below, account.credit);
}

/// What the buffer has left, and who takes it.
class Division {
 public:
  Division(std::span<CreditAccount*> accounts, std::size_t buffer, std::int64_t now)
      : accounts_(accounts), buffer_(buffer), now_(now) {
    for (const auto* account : accounts_) {
      used_ += static_cast<std::size_t>(account->outstanding()) * cost_of(*account);
      if (wants_more(*account) || account->outstanding() > 0) ++active_;
    }
  }

  void in_turns(std::uint64_t& turns) {
    std::vector<CreditAccount*> waiting;
    std::ranges::copy_if(accounts_, std::back_inserter(waiting),
                         [](const auto* account) { return wants_more(*account); });
    std::ranges::stable_sort(waiting, {}, &CreditAccount::turn);
    for (auto* account : waiting) {
      const auto share = share_of(*account, buffer_ / std::max<std::size_t>(1, active_));
      if (share > 4 && account->outstanding() > share * 3 / 4) continue;  // Not for a trifle.
      const auto wanted =
          std::min(share - account->outstanding(), account->offered - account->credit);
      const auto chunks = std::min(wanted, room_for(*account));
      if (chunks <= 0) continue;
      give(*account, chunks);
      account->granted = true;
      account->turn = ++turns;
      account->granted_at = now_;
    }
    waits_ = std::ranges::any_of(waiting, [](const auto* a) { return a->outstanding() == 0; });
  }

  void ahead() {
    if (waits_) return;
    const auto lately = [this](const auto* account) {
      return now_ - account->heard_at < kLatelyUs && now_ - account->told_at < kLatelyUs;
    };
    const auto count = static_cast<std::size_t>(std::ranges::count_if(accounts_, lately));
    for (auto* account : accounts_) {
      if (!lately(account) || wants_more(*account)) continue;
      const auto share = static_cast<std::int64_t>(buffer_ / 2 / count / cost_of(*account));
      const auto chunks = std::min(share - account->outstanding(), room_for(*account));
      if (chunks > 0) give(*account, chunks);
    }
  }

 private:
  static std::int64_t share_of(const CreditAccount& account, std::size_t bytes) {
    return std::max<std::int64_t>(1, static_cast<std::int64_t>(bytes / cost_of(account)));
  }

  std::int64_t room_for(const CreditAccount& account) const {
    if (used_ == 0) return share_of(account, buffer_);
    return used_ >= buffer_ ? 0 : static_cast<std::int64_t>((buffer_ - used_) / cost_of(account));
  }

  void give(CreditAccount& account, std::int64_t chunks) {
    grant(account, chunks);
    used_ += static_cast<std::size_t>(chunks) * cost_of(account);
  }

  std::span<CreditAccount*> accounts_;
  std::size_t buffer_;
  std::int64_t now_;
  std::size_t used_ = 0;
  std::size_t active_ = 0;
  bool waits_ = false;
};

}  // namespace

void lapse_credit(CreditAccount& account, std::int64_t now) {
  if (now - account.told_at > kCreditCountsUs) account.credit = account.arrived;
  account.credit = std::max(account.credit, account.arrived);
}

std::size_t buffer_cost(std::size_t chunk_bytes) {
  if (chunk_bytes == 0) chunk_bytes = kUnknownChunkBytes;
  return (chunk_bytes + kPage - 1) / kPage * kPage + kPage;
}

void divide_credit(std::span<CreditAccount*> accounts, std::size_t receive_buffer_bytes,
                   std::int64_t now, std::uint64_t& turns) {
  Division division(accounts, receive_buffer_bytes, now);
  division.in_turns(turns);
  division.ahead();
}

}  // namespace voxatlas
