#include "atlas/scan_order.hpp"

#include <fmt/format.h>

namespace voxatlas {

void ScanOrder::start_from(const std::vector<Mark>& marks) {
  queues_.clear();
  for (const auto& mark : marks) queues_[{mark.source, mark.session}].next = mark.seq + 1;
}

Result<ScanOrder::Offer> ScanOrder::offer(ShardScan scan, std::int64_t acked_below) {
  const Session session{scan.source, scan.session};
  const auto wanted = next(scan.source, scan.session);
  const auto refuse = [&](const std::string& why) {
    return fail(ErrorCode::kInvalid, fmt::format("scan {} of source \"{}\", session {}: {}",
                                                 scan.seq, scan.source, scan.session, why));
  };
  if (acked_below > wanted) {
    return refuse(
        fmt::format("all below {} were acknowledged, but this shard has only those below "
                    "{}: acknowledged scans are lost",
                    acked_below, wanted));
  }
  if (scan.seq < 0) return refuse("a negative number");
  if (scan.seq < wanted) return Offer::kDuplicate;
  if (scan.seq - wanted > kMaxWaiting) {
    return refuse(fmt::format("more than {} ahead of {}, the next one", kMaxWaiting, wanted));
  }
  const auto seq = scan.seq;
  auto& queue = queues_[session];
  const bool is_new = queue.waiting.try_emplace(seq, std::move(scan)).second;
  return is_new ? Offer::kTaken : Offer::kDuplicate;
}

std::vector<ShardScan> ScanOrder::take_ready() {
  std::vector<ShardScan> ready;
  for (auto& [session, queue] : queues_) {
    auto first = queue.waiting.begin();
    while (first != queue.waiting.end() && first->first == queue.next) {
      ready.push_back(std::move(first->second));
      first = queue.waiting.erase(first);
      ++queue.next;
    }
  }
  return ready;
}

std::size_t ScanOrder::waiting() const {
  std::size_t count = 0;
  for (const auto& [session, queue] : queues_) count += queue.waiting.size();
  return count;
}

std::size_t ScanOrder::waiting_bytes() const {
  std::size_t bytes = 0;
  for (const auto& [session, queue] : queues_) {
    for (const auto& [seq, scan] : queue.waiting) {
      for (const auto& [key, delta] : scan.deltas) bytes += delta.size();
    }
  }
  return bytes;
}

std::int64_t ScanOrder::next(const std::string& source, std::int64_t session) const {
  const auto queue = queues_.find({source, session});
  return queue == queues_.end() ? 0 : queue->second.next;
}

}  // namespace voxatlas
