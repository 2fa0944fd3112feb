#include "map/board_fit.hpp"

#include "boards.hpp"

namespace swiftlet::tools {

std::vector<BoardFit> fit_to_boards(std::uint64_t blob_bytes, std::uint64_t windows) {
  std::vector<BoardFit> fits;
  for (const BoardEntry& board : kBoards) {
    const auto nodes = static_cast<double>(board.capacity.search_nodes);
    const bool reaches_all = board.capacity.search_nodes >= windows;
    fits.push_back({board.name, board.memory, board.capacity, blob_bytes <= board.memory.map_bytes,
                    reaches_all ? 1 : nodes / static_cast<double>(windows)});
  }
  return fits;
}

}  // namespace swiftlet::tools
