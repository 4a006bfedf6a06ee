// A plain main for a fuzz target: any compiler replays the corpus and a fixed number of seeded
// mutations of it, so that every build of CI walks the decoders' error paths. Where libFuzzer is,
// it brings its own main and this file is left out.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<std::uint8_t>;

std::vector<Bytes> read_corpus(int argc, char** argv) {
  std::vector<Bytes> corpus{{}};
  for (int i = 1; i < argc; ++i) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(argv[i])) {
      if (!entry.is_regular_file()) continue;
      std::ifstream in(entry.path(), std::ios::binary);
      corpus.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
  }
  return corpus;
}

void mutate(Bytes& bytes, std::mt19937_64& rng) {
  for (std::uint64_t i = rng() % 8; i > 0; --i) {
    const auto at = bytes.empty() ? 0 : rng() % bytes.size();
    switch (rng() % 5) {
      case 0:
        bytes.resize(at);
        break;
      case 1:
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                     static_cast<std::uint8_t>(rng()));
        break;
      case 2:
        if (!bytes.empty()) bytes[at] = static_cast<std::uint8_t>(rng());
        break;
      case 3:
        if (!bytes.empty()) bytes[at] ^= static_cast<std::uint8_t>(1u << rng() % 8);
        break;
      default:
        if (!bytes.empty()) bytes[at] = rng() % 2 == 0 ? 0xff : 0;
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  const auto corpus = read_corpus(argc, argv);
  for (const auto& bytes : corpus) LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  std::mt19937_64 rng(20261122);
  const char* text = std::getenv("VOX_FUZZ_RUNS");
  const long runs = text == nullptr ? 20'000 : std::strtol(text, nullptr, 10);
  for (long run = 0; run < runs; ++run) {
    Bytes bytes = corpus[rng() % corpus.size()];
    if (bytes.empty()) bytes.resize(rng() % 256);
    mutate(bytes, rng);
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
  std::printf("%zu files and %ld mutations of them: no crash\n", corpus.size() - 1, runs);
  return 0;
}
