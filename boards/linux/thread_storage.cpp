#include "linux/thread_storage.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>

namespace swiftlet::board {
namespace {

constexpr std::chrono::milliseconds kPause{20};

}  // namespace

ThreadStorage::ThreadStorage(hal::Storage& storage) : storage_(storage), thread_([this] { work(); }) {}

ThreadStorage::~ThreadStorage() {
  ends_ = true;
  thread_.join();
}

bool ThreadStorage::append(std::string_view name, std::span<const std::byte> bytes) {
  const std::size_t written = written_.load(std::memory_order_relaxed);
  if (name_.empty()) name_ = name;
  const std::size_t waiting = written - stored_.load(std::memory_order_acquire);
  if (bytes.size() > kRing - waiting || name != name_) full_ = true;
  if (full_) return false;
  const std::size_t at = written % kRing;
  const std::size_t first = std::min(bytes.size(), kRing - at);
  std::copy_n(bytes.begin(), first, ring_.begin() + static_cast<std::ptrdiff_t>(at));
  std::copy(bytes.begin() + static_cast<std::ptrdiff_t>(first), bytes.end(), ring_.begin());
  written_.store(written + bytes.size(), std::memory_order_release);
  return true;
}

bool ThreadStorage::drain() {
  while (!full_ && stored_ != written_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  errno = error_;
  return !full_;
}

/// Whatever waits; true when something did.
bool ThreadStorage::write_waiting() {
  const std::size_t stored = stored_.load(std::memory_order_relaxed);
  const std::size_t waiting = written_.load(std::memory_order_acquire) - stored;
  if (waiting == 0 || error_ != 0) return false;
  const std::size_t at = stored % kRing;
  const std::size_t count = std::min(waiting, kRing - at);
  errno = 0;
  if (!storage_.append(name_, std::span(ring_).subspan(at, count))) {
    error_ = errno != 0 ? errno : EIO;
    full_ = true;
    return false;
  }
  stored_.store(stored + count, std::memory_order_release);
  return true;
}

void ThreadStorage::work() {
  while (!ends_) {
    while (write_waiting()) {
    }
    std::this_thread::sleep_for(kPause);
  }
  while (write_waiting()) {
  }
}

}  // namespace swiftlet::board
