#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace voxatlas {

/// Threads that live as long as this and share out pieces of work: threads made anew for each
/// picture start late and on the same core.
///
/// Threads: run() by one thread at a time; the work must not throw.
class Workers {
 public:
  /// `count`: the calling thread is one of them; 1 makes no other. 0 counts as 1.
  explicit Workers(std::size_t count);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  std::size_t count() const { return threads_.size() + 1; }

  /// Calls work(piece, worker) once for each piece below `pieces`, the next piece to whoever is
  /// free; `worker` is below count(). Returns when all are done.
  using Work = std::function<void(std::size_t piece, std::size_t worker)>;
  void run(std::size_t pieces, const Work& work);

 private:
  void serve(std::size_t worker);
  void take_pieces(const Work& work, std::size_t pieces, std::size_t worker);

  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
  std::condition_variable begun_, done_;
  const Work* work_ = nullptr;  // With all below, under mutex_.
  std::size_t pieces_ = 0;
  std::size_t round_ = 0;  // Counts calls of run().
  std::size_t busy_ = 0;   // Threads that have not finished this round.
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace voxatlas
