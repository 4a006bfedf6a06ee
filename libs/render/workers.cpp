#include "render/workers.hpp"

namespace voxatlas {

Workers::Workers(std::size_t count) {
  for (std::size_t worker = 1; worker < count; ++worker) {
    threads_.emplace_back([this, worker] { serve(worker); });
  }
}

Workers::~Workers() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  begun_.notify_all();
  for (auto& thread : threads_) thread.join();
}

void Workers::run(std::size_t pieces, const Work& work) {
  {
    const std::lock_guard lock(mutex_);
    work_ = &work;
    pieces_ = pieces;
    next_ = 0;
    busy_ = threads_.size();
    ++round_;
  }
  begun_.notify_all();
  take_pieces(work, pieces, 0);
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return busy_ == 0; });
}

void Workers::serve(std::size_t worker) {
  std::unique_lock lock(mutex_);
  for (std::size_t served = 0;;) {
    begun_.wait(lock, [&] { return ending_ || round_ != served; });
    if (ending_) return;
    served = round_;
    const Work& work = *work_;
    const std::size_t pieces = pieces_;
    lock.unlock();
    take_pieces(work, pieces, worker);
    lock.lock();
    if (--busy_ == 0) done_.notify_one();
  }
}

void Workers::take_pieces(const Work& work, std::size_t pieces, std::size_t worker) {
  for (std::size_t piece = next_++; piece < pieces; piece = next_++) work(piece, worker);
}

}  // namespace voxatlas
