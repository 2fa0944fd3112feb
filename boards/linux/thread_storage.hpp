#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <string>
#include <thread>

#include "swiftlet/hal/storage.hpp"

namespace swiftlet::board {

/// Appends to another storage by a thread of its own, so that a slow disk holds nobody up: a second of waiting costs
/// what a log grows in it. Bytes wait in a ring of fixed size; `append` copies, and refuses for good once the ring is
/// full or the storage has refused. One thread appends.
class ThreadStorage final : public hal::Storage {
 public:
  static constexpr std::size_t kRing = std::size_t{1} << 20U;  // of a log, some 40 s

  /// `storage` outlives this object and is used by nobody else.
  explicit ThreadStorage(hal::Storage& storage);
  ~ThreadStorage();
  ThreadStorage(const ThreadStorage&) = delete;
  ThreadStorage& operator=(const ThreadStorage&) = delete;

  /// What has been stored by now.
  std::optional<std::size_t> read(std::string_view name, std::size_t offset, std::span<std::byte> into) override {
    return storage_.read(name, offset, into);
  }
  /// The first name is the only one.
  bool append(std::string_view name, std::span<const std::byte> bytes) override;
  /// Nothing is: always false.
  bool remove(std::string_view /*name*/) override { return false; }

  /// Waits until all is stored; false when something could not be, and errno says why the disk refused.
  bool drain();

 private:
  void work();
  bool write_waiting();

  hal::Storage& storage_;
  std::string name_;  // set before the first byte is seen by the thread
  std::array<std::byte, kRing> ring_;
  std::atomic<std::size_t> written_{0};  // bytes ever, by append
  std::atomic<std::size_t> stored_{0};   // ... by the thread
  std::atomic<bool> full_{false};
  std::atomic<int> error_{0};
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace swiftlet::board
