#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace swiftlet::tools {

using Index3 = std::array<std::int32_t, 3>;

/// Half-open box of grid cells: lo <= i < hi.
struct GridBox {
  Index3 lo;
  Index3 hi;
  friend bool operator==(const GridBox&, const GridBox&) = default;
};

inline std::uint64_t volume(const GridBox& box) {
  std::uint64_t product = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (box.lo[axis] >= box.hi[axis]) return 0;
    product *= static_cast<std::uint64_t>(box.hi[axis] - box.lo[axis]);
  }
  return product;
}

inline GridBox intersection(const GridBox& a, const GridBox& b) {
  GridBox common{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    common.lo[axis] = a.lo[axis] > b.lo[axis] ? a.lo[axis] : b.lo[axis];
    common.hi[axis] = a.hi[axis] < b.hi[axis] ? a.hi[axis] : b.hi[axis];
  }
  return common;
}

/// A dense grid of bits in rows along x, each row starting at a word; bits beyond the row's end are zero.
class BitGrid {
 public:
  using Word = std::uint64_t;
  static constexpr std::int32_t kWordBits = 64;

  BitGrid() = default;
  explicit BitGrid(const Index3& size);

  [[nodiscard]] const Index3& size() const { return size_; }
  [[nodiscard]] GridBox box() const { return {{0, 0, 0}, size_}; }
  [[nodiscard]] std::size_t row_words() const { return row_words_; }
  [[nodiscard]] std::span<Word> row(std::int32_t y, std::int32_t z) {
    return {words_.data() + row_start(y, z), row_words_};
  }
  [[nodiscard]] std::span<const Word> row(std::int32_t y, std::int32_t z) const {
    return {words_.data() + row_start(y, z), row_words_};
  }
  [[nodiscard]] bool test(const Index3& i) const {
    return (row(i[1], i[2])[static_cast<std::size_t>(i[0]) / 64] >> (i[0] % 64) & 1U) != 0;
  }

  /// True when every cell of the box is set; the box lies in the grid.
  [[nodiscard]] bool all_set(const GridBox& box) const;
  /// True when no cell of the box is.
  [[nodiscard]] bool none_set(const GridBox& box) const;
  void set(const GridBox& box);
  void clear(const GridBox& box);
  [[nodiscard]] std::uint64_t count() const;

 private:
  [[nodiscard]] std::size_t row_start(std::int32_t y, std::int32_t z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(y)) *
           row_words_;
  }

  Index3 size_{};
  std::size_t row_words_ = 0;
  std::vector<Word> words_;
};

}  // namespace swiftlet::tools
