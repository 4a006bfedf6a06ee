#include "tilestore/source_claims.hpp"

namespace voxatlas {

std::int64_t SourceClaims::claim(const std::string& source, std::int64_t client, std::int64_t now) {
  if (const auto other = holder(source, now); other != 0 && other != client) return other;
  if (claims_.size() >= kMaxClaims && !claims_.contains(source)) {
    std::erase_if(claims_, [now](const auto& entry) { return entry.second.until <= now; });
    if (claims_.size() >= kMaxClaims) return 0;
  }
  claims_[source] = {client, now + kLeaseUs};
  return client;
}

void SourceClaims::give_back(const std::string& source, std::int64_t client) {
  const auto claim = claims_.find(source);
  if (claim != claims_.end() && claim->second.holder == client) claims_.erase(claim);
}

std::int64_t SourceClaims::holder(const std::string& source, std::int64_t now) const {
  const auto claim = claims_.find(source);
  return claim != claims_.end() && now < claim->second.until ? claim->second.holder : 0;
}

}  // namespace voxatlas
