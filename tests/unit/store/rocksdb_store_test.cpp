#include "store/rocksdb_store.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <map>
#include <thread>

#include "support/engine.hpp"
#include "support/temp_dir.hpp"

namespace voxatlas {
namespace {

namespace fs = std::filesystem;

TileKey key(std::uint64_t code) { return TileKey::from_morton(code).value(); }

std::unique_ptr<RocksDbStore> open_store(const std::string& directory) {
  auto store = RocksDbStore::open(directory);
  if (!store) FAIL(store.error().message);
  return std::move(*store);
}

/// What round `n` writes: tile n mod 64 in version n, and a journal record of n.
StoredTile tile_of_round(std::uint64_t n) { return {key(n % 64), n, Bytes(200, n & 0xff)}; }
Bytes record_of_round(std::uint64_t n) {
  Bytes bytes;
  ByteWriter(bytes).put(n);
  return bytes;
}

/// Writes rounds for ever, telling each acknowledged one over the pipe. In a child process.
[[noreturn]] void write_rounds(const std::string& directory, std::uint64_t first, int pipe) {
  auto store = RocksDbStore::open(directory);
  if (!store) _exit(3);
  const auto epoch = (*store)->acquire(0);
  for (std::uint64_t n = first; epoch; ++n) {
    const StoredTile tiles[] = {tile_of_round(n)};
    const Bytes records[] = {record_of_round(n)};
    if (!(*store)->append(0, *epoch, records)) _exit(4);
    if (!(*store)->put(0, *epoch, tiles)) _exit(5);
    if (n % 50 == 0 && !(*store)->trim(0, *epoch, n, {})) _exit(6);
    if (::write(pipe, &n, sizeof n) != sizeof n) _exit(7);
  }
  _exit(8);
}

/// Starts write_rounds, waits until `rounds` are acknowledged, kills it. Returns the last round
/// the child told of.
std::uint64_t kill_after(const std::string& directory, std::uint64_t first, std::uint64_t rounds) {
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    ::close(ends[0]);
    write_rounds(directory, first, ends[1]);
  }
  ::close(ends[1]);
  std::uint64_t told = first - 1;
  std::uint64_t n = 0;
  while (told < first - 1 + rounds && ::read(ends[0], &n, sizeof n) == sizeof n) told = n;
  ::kill(child, SIGKILL);
  while (::read(ends[0], &n, sizeof n) == sizeof n) told = n;
  ::close(ends[0]);
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  REQUIRE(WIFSIGNALED(status));
  return told;
}

/// Every acknowledged round is there. Returns the last round that the journal holds.
std::uint64_t check_rounds(RocksDbStore& store, std::uint64_t told) {
  REQUIRE(store.verify(0).has_value());
  std::uint64_t last = 0;
  const auto replayed = store.replay(0, [&](JournalPosition position, ByteView record) -> Status {
    last = ByteReader(record).get<std::uint64_t>();
    if (position != last) return fail(ErrorCode::kCorrupt, "a record at another's position");
    return {};
  });
  REQUIRE(replayed.has_value());
  if (last == 0) last = told;  // All trimmed.
  REQUIRE(last >= told);
  REQUIRE(last <= told + 1);
  for (std::uint64_t n = told < 64 ? 1 : told - 63; n <= told; ++n) {
    const auto tile = store.get(0, key(n % 64)).value();
    REQUIRE(tile.has_value());
    const bool next_came = n % 64 == (told + 1) % 64 && tile->version == told + 1;
    REQUIRE((tile->version == n || next_came));
    REQUIRE(tile->bytes == tile_of_round(tile->version).bytes);
  }
  return last;
}

TEST_CASE("kill -9 loses nothing that was acknowledged", "[store][rocksdb]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const test::TempDir folder;
  std::uint64_t written = 0;
  for (int round = 0; round < 8; ++round) {
    const auto told = kill_after(folder / "store", written + 1, 1 + rng() % 120);
    CAPTURE(round, told);
    REQUIRE(told > written);
    const auto store = open_store(folder / "store");
    written = check_rounds(*store, told);
    const StoredTile tiles[] = {tile_of_round(written)};  // Redo: the record came, perhaps no tile.
    REQUIRE(store->put(0, store->acquire(0).value(), tiles).has_value());
  }
}

TEST_CASE("a folder that is open is refused to a second opener, by name", "[store][rocksdb]") {
  const test::TempDir folder;
  const auto first = open_store(folder / "store");
  const auto second = RocksDbStore::open(folder / "store");
  REQUIRE_FALSE(second.has_value());
  REQUIRE(second.error().code == ErrorCode::kUnavailable);
  REQUIRE(second.error().message.find(folder / "store") != std::string::npos);
  REQUIRE(second.error().message.find("in use") != std::string::npos);
}

TEST_CASE("a folder without a store is refused where none may be made", "[store][rocksdb]") {
  const test::TempDir folder;
  const auto none = RocksDbStore::open(folder / "none", {.create = false});
  REQUIRE(none.error().code == ErrorCode::kNotFound);
  REQUIRE_FALSE(fs::exists(folder / "none/CURRENT"));
  std::ofstream(folder / "file") << "no folder";
  REQUIRE(RocksDbStore::open(folder / "file").error().code == ErrorCode::kIo);
}

std::vector<std::string> files_of(const std::string& directory, const std::string& part) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(directory)) {
    const auto name = entry.path().filename().string();
    if (name.find(part) != std::string::npos && entry.file_size() > 0) names.push_back(name);
  }
  return names;
}

void flip_bit(const std::string& path, std::uint64_t bit) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(bit / 8));
  const auto byte = static_cast<char>(file.get() ^ 1 << bit % 8);
  file.seekp(static_cast<std::streamoff>(bit / 8));
  file.put(byte);
}

/// True where the damaged store says so, on opening or on verifying; false where it opens and
/// verifies: then it must have everything.
bool reported_or_whole(const std::string& directory, std::uint64_t told) {
  const auto store = RocksDbStore::open(directory);
  if (!store) return true;
  if (!(*store)->verify(0)) return true;
  check_rounds(**store, told);
  return false;
}

TEST_CASE("bits flipped in any file never lose a tile silently", "[store][rocksdb]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const test::TempDir folder;
  const auto told = kill_after(folder / "logged", 1, 100);
  fs::copy(folder / "logged", folder / "flushed", fs::copy_options::recursive);
  open_store(folder / "flushed");
  int reported = 0;
  for (int i = 0; i < 120; ++i) {
    const bool log = i % 2 == 0;
    fs::remove_all(folder / "damaged");
    fs::copy(folder / (log ? "logged" : "flushed"), folder / "damaged",
             fs::copy_options::recursive);
    const auto names = files_of(folder / "damaged", log          ? ".log"
                                                    : i % 4 == 1 ? ".sst"
                                                                 : "MANIFEST");
    REQUIRE_FALSE(names.empty());
    const auto path = folder / ("damaged/" + names[rng() % names.size()]);
    const auto bit = rng() % (fs::file_size(path) * 8);
    CAPTURE(path, bit);
    flip_bit(path, bit);
    reported += reported_or_whole(folder / "damaged", told);
  }
  REQUIRE(reported > 90);  // Most bits matter; those of padding do not.
}

TEST_CASE("a log or manifest that lost its end is refused", "[store][rocksdb]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const test::TempDir folder;
  const auto told = kill_after(folder / "logged", 1, 60);
  fs::copy(folder / "logged", folder / "flushed", fs::copy_options::recursive);
  open_store(folder / "flushed");
  for (int i = 0; i < 30; ++i) {
    const bool log = i % 2 == 0;
    fs::remove_all(folder / "damaged");
    fs::copy(folder / (log ? "logged" : "flushed"), folder / "damaged",
             fs::copy_options::recursive);
    for (const auto& name : files_of(folder / "damaged", log ? ".log" : "MANIFEST")) {
      const auto path = folder / ("damaged/" + name);
      fs::resize_file(path, rng() % fs::file_size(path));
    }
    CAPTURE(i, log);
    reported_or_whole(folder / "damaged", told);
  }
}

TEST_CASE("control: without the file ACKED a log that lost its end opens without a word",
          "[store][rocksdb]") {
  const test::TempDir folder;
  const auto told = kill_after(folder / "store", 1, 60);
  fs::remove(folder / "store/ACKED");
  const auto logs = files_of(folder / "store", ".log");
  REQUIRE(logs.size() == 1);
  const auto path = folder / ("store/" + logs.front());
  fs::resize_file(path, fs::file_size(path) / 2);
  const auto store = open_store(folder / "store");
  REQUIRE(store->verify(0).has_value());
  const auto tile = store->get(0, key(told % 64)).value();
  REQUIRE((!tile.has_value() || tile->version < told));
}

TEST_CASE("a disk that is nearly full is refused before anything is written", "[store][rocksdb]") {
  const test::TempDir folder;
  RocksDbOptions full;
  full.reserve_bytes = std::size_t{1} << 60;
  const Bytes records[] = {record_of_round(1)};
  const StoredTile tiles[] = {tile_of_round(1)};
  {
    const auto store = RocksDbStore::open(folder / "store", full).value();
    const auto epoch = store->acquire(0).value();
    REQUIRE(store->append(0, epoch, records).error().code == ErrorCode::kNoSpace);
    REQUIRE(store->put(0, epoch, tiles).error().code == ErrorCode::kNoSpace);
    REQUIRE(store->trim(0, epoch, 0, {}).has_value());  // What frees is never refused.
  }
  const auto store = open_store(folder / "store");
  const auto epoch = store->acquire(0).value();
  REQUIRE(store->scan(0, key(0), 10).value().empty());
  REQUIRE(store->append(0, epoch, records).value() == 1);
  REQUIRE(store->put(0, epoch, tiles).has_value());
}

TEST_CASE("appends by many threads at once each get their own place", "[store][rocksdb]") {
  const test::TempDir folder;
  const auto store = open_store(folder / "store");
  const auto old = store->acquire(0).value();
  const auto epoch = store->acquire(0).value();
  constexpr std::uint64_t kThreads = 8, kEach = 30;
  std::vector<std::map<JournalPosition, Bytes>> mine(kThreads);
  std::atomic<int> refused = 0;
  std::vector<std::thread> threads;
  for (std::uint64_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      for (std::uint64_t i = 0; i < kEach; ++i) {
        const Bytes records[] = {record_of_round(t * kEach + i), record_of_round(~t)};
        if (i % 5 == 0) refused += store->append(0, old, records).has_value() ? 0 : 1;
        const auto last = store->append(0, epoch, records);
        if (!last) continue;
        mine[t][*last - 1] = records[0];
        mine[t][*last] = records[1];
      }
    });
  }
  for (auto& thread : threads) thread.join();
  std::map<JournalPosition, Bytes> expected, found;
  for (auto& some : mine) expected.merge(some);
  REQUIRE(store
              ->replay(0,
                       [&](JournalPosition position, ByteView record) -> Status {
                         found[position] = Bytes(record.begin(), record.end());
                         return {};
                       })
              .has_value());
  REQUIRE(refused == kThreads * kEach / 5);
  REQUIRE(expected.size() == 2 * kThreads * kEach);
  REQUIRE(found == expected);
}

}  // namespace
}  // namespace voxatlas
