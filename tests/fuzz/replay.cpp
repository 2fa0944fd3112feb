#include <cstdint>
#include <cstdio>
#include <filesystem>

#include "map/file_io.hpp"

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer calls it so
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

/// Runs a fuzz target over the files of a folder, and over every prefix and single-bit change of each, so that every
/// compiler and every `./go test` exercises it.
int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::size_t inputs = 0;
  const auto run = [&inputs](const std::vector<std::byte>& bytes, std::size_t size) {
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), size);
    ++inputs;
  };
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) {
    auto bytes = swiftlet::tools::read_file(entry.path().string());
    if (!bytes) return 1;
    for (std::size_t size = 0; size <= bytes->size(); ++size) run(*bytes, size);
    for (std::size_t bit = 0; bit < 8 * bytes->size(); ++bit) {
      const auto mask = static_cast<std::byte>(1U << (bit % 8));
      (*bytes)[bit / 8] ^= mask;
      run(*bytes, bytes->size());
      (*bytes)[bit / 8] ^= mask;
    }
  }
  std::printf("%zu inputs\n", inputs);
  return inputs > 0 ? 0 : 1;
}
