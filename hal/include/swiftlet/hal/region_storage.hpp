#pragma once
#include <optional>

#include "swiftlet/hal/storage.hpp"

namespace swiftlet::hal {

/// Files in a region of memory, in pieces one after another: what is appended to the newest piece's file makes that
/// piece longer, anything else begins a new one of 68 bytes and what it holds. A read passes every piece, so keep them
/// few.
///
/// All that it knows lies in the region. Where memory keeps its content through a reset the next object finds the files
/// again, up to the last append that was complete; a region that holds no files, or damaged ones, begins empty. Only a
/// reset within `remove` loses them. The bytes of files carry no checksum.
class RegionStorage final : public Storage {
 public:
  /// Four-byte aligned, below 4 GiB, used by nobody else.
  explicit RegionStorage(std::span<std::byte> region);
  RegionStorage(const RegionStorage&) = delete;
  RegionStorage& operator=(const RegionStorage&) = delete;

  std::optional<std::size_t> read(std::string_view name, std::size_t offset, std::span<std::byte> into) override;
  bool append(std::string_view name, std::span<const std::byte> bytes) override;
  bool remove(std::string_view name) override;

  [[nodiscard]] std::size_t free_bytes() const { return limit_ - used(); }
  /// From now on as if the region had no more room than this; at most what it has.
  void set_free_bytes(std::size_t bytes);

 private:
  struct Piece {
    std::string_view name;
    std::span<std::byte> bytes;
    std::size_t at = 0;   // of the region, where its header begins
    std::size_t end = 0;  // 0: no piece
  };

  [[nodiscard]] std::size_t used() const;
  void set_used(std::size_t used);
  [[nodiscard]] Piece piece_at(std::size_t at) const;
  [[nodiscard]] Piece first() const;
  [[nodiscard]] bool is_whole() const;
  bool begin_piece(std::string_view name);
  void find_last();

  std::span<std::byte> region_;
  std::size_t limit_;     // of the region's bytes, those that may be used
  std::size_t last_ = 0;  // where the newest piece begins; 0: there is none
};

}  // namespace swiftlet::hal
