#include "atlas/update_tally.hpp"

namespace voxatlas {

void UpdateTally::on_update(std::int64_t now) {
  ++heard_;
  last_update_ = now;
}

void UpdateTally::on_status(std::int64_t instance, std::uint64_t published, std::int64_t now) {
  const bool is_new = instance_ != instance;
  instance_ = instance;
  told_ = published;
  const bool is_quiet = last_update_ == 0 || now - last_update_ >= kQuietUs;
  if (!is_new && (heard_ == told_ || !is_quiet)) return;
  // From here on we count on the store's word; the list is made after it, and so holds them all.
  heard_ = told_;
  must_list_ = true;
}

void UpdateTally::begin_list() {
  must_list_ = false;
  is_listing_ = true;
}

void UpdateTally::end_list(bool done) {
  is_listing_ = false;
  must_list_ = must_list_ || !done;
}

}  // namespace voxatlas
