#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "swiftlet/storage.hpp"

namespace swiftlet::tools {

/// What one board makes of a map, by the promises of its board_config.hpp.
struct BoardFit {
  std::string name;  ///< its folder below boards/
  BoardMemory memory{};
  Capacity capacity{};
  bool holds_map = false;  ///< the blob fits into its map region
  double search_share =
      0;  ///< share of the map's windows that one search may reach, 0 to 1; 1 is a node for each window
};

/// Every board, in the order of their names.
std::vector<BoardFit> fit_to_boards(std::uint64_t blob_bytes, std::uint64_t windows);

}  // namespace swiftlet::tools
