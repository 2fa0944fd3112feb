#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "swiftlet/corridor_search.hpp"

namespace swiftlet::test {

/// Storage of a search that reaches at most `kNodes` windows (a power of two, so that the hash is one as well). It
/// starts full of rubbish, which a search must not mind.
template <std::size_t kNodes>
class SearchMemory {
 public:
  SearchMemory() {
    nodes_.fill({77, 77, 77, 77});
    open_.fill({-1, 77});
    hash_.fill(1);
  }
  /// As a board with room for `capacity` <= kNodes windows has it.
  SearchScratch scratch(std::size_t capacity = kNodes) {
    return {std::span(nodes_).first(capacity), std::span(open_).first(capacity), hash_};
  }

 private:
  std::array<SearchNode, kNodes> nodes_;
  std::array<OpenEntry, kNodes> open_;
  std::array<std::uint32_t, 2 * kNodes> hash_;
};

}  // namespace swiftlet::test
