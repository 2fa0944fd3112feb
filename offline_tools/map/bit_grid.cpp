#include "map/bit_grid.hpp"

#include <bit>

namespace swiftlet::tools {
namespace {

/// Calls `use(word index, mask)` for the words that cover bits lo to hi - 1 of a row, until it returns false.
template <typename Use>
bool for_each_word(std::int32_t lo, std::int32_t hi, const Use& use) {
  const auto first = static_cast<std::size_t>(lo) / 64;
  const auto last = static_cast<std::size_t>(hi - 1) / 64;
  for (std::size_t word = first; word <= last; ++word) {
    BitGrid::Word mask = ~BitGrid::Word{0};
    if (word == first) mask &= ~BitGrid::Word{0} << (lo % 64);
    if (word == last) mask &= ~BitGrid::Word{0} >> (63 - (hi - 1) % 64);
    if (!use(word, mask)) return false;
  }
  return true;
}

}  // namespace

BitGrid::BitGrid(const Index3& size)
    : size_(size),
      row_words_((static_cast<std::size_t>(size[0]) + 63) / 64),
      words_(row_words_ * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2])) {}

bool BitGrid::all_set(const GridBox& box) const {
  for (std::int32_t z = box.lo[2]; z < box.hi[2]; ++z) {
    for (std::int32_t y = box.lo[1]; y < box.hi[1]; ++y) {
      const auto words = row(y, z);
      const bool full =
          for_each_word(box.lo[0], box.hi[0], [&](std::size_t i, Word mask) { return (~words[i] & mask) == 0; });
      if (!full) return false;
    }
  }
  return true;
}

bool BitGrid::none_set(const GridBox& box) const {
  for (std::int32_t z = box.lo[2]; z < box.hi[2]; ++z) {
    for (std::int32_t y = box.lo[1]; y < box.hi[1]; ++y) {
      const auto words = row(y, z);
      const bool empty =
          for_each_word(box.lo[0], box.hi[0], [&](std::size_t i, Word mask) { return (words[i] & mask) == 0; });
      if (!empty) return false;
    }
  }
  return true;
}

void BitGrid::set(const GridBox& box) {
  if (box.lo[0] >= box.hi[0]) return;
  for (std::int32_t z = box.lo[2]; z < box.hi[2]; ++z) {
    for (std::int32_t y = box.lo[1]; y < box.hi[1]; ++y) {
      const auto words = row(y, z);
      for_each_word(box.lo[0], box.hi[0], [&](std::size_t i, Word mask) { return words[i] |= mask, true; });
    }
  }
}

void BitGrid::clear(const GridBox& box) {
  if (box.lo[0] >= box.hi[0]) return;
  for (std::int32_t z = box.lo[2]; z < box.hi[2]; ++z) {
    for (std::int32_t y = box.lo[1]; y < box.hi[1]; ++y) {
      const auto words = row(y, z);
      for_each_word(box.lo[0], box.hi[0], [&](std::size_t i, Word mask) { return words[i] &= ~mask, true; });
    }
  }
}

std::uint64_t BitGrid::count() const {
  std::uint64_t bits = 0;
  for (const Word word : words_) bits += static_cast<std::uint64_t>(std::popcount(word));
  return bits;
}

}  // namespace swiftlet::tools
