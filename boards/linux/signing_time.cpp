#include "linux/signing_time.hpp"

#include <charconv>
#include <filesystem>
#include <span>
#include <vector>

#include "cli/failure.hpp"
#include "map/file_io.hpp"

namespace swiftlet::board {
namespace {

using tools::ExitStatus;
using tools::Failure;

constexpr std::uint64_t kEnd = std::uint64_t{1} << 48U;  // of what a frame has room for

}  // namespace

SigningTime::SigningTime(const std::string& key_path) : path_(key_path + ".time") {
  if (!std::filesystem::exists(path_)) return;
  const std::vector<std::byte> bytes = tools::unwrap(tools::read_file(path_));
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), kept_);
  const bool is_whole = error == std::errc() && std::string(end, text.data() + text.size()) == "\n";
  if (!is_whole || kept_ >= kEnd) {
    throw Failure{ExitStatus::kBadFile, path_ + ": is no time of signatures"};
  }
}

void SigningTime::keep(std::uint64_t used) {
  if (!written_ || used + kAhead / 2 > kept_) write(used + kAhead);
}

void SigningTime::write(std::uint64_t time) {
  const std::string text = std::to_string(time) + "\n";
  tools::unwrap(tools::write_file_atomically(path_, std::as_bytes(std::span(text))));
  kept_ = time;
  written_ = true;
}

}  // namespace swiftlet::board
