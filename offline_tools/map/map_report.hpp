#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "map/board_fit.hpp"
#include "swiftlet/box_graph_view.hpp"

namespace swiftlet::tools {

/// What one changed option would do to a map in pieces (alternatives.hpp).
struct Alternative {
  std::string option;            ///< as on the command line, "--unknown free"
  double largest_component = 0;  ///< share of the free volume, 0 to 1
};

/// What there is to say about a map (contract.md, `swiftlet-map/1`, and more). Lengths in metres, frame W.
struct MapReport {
  std::string source;         ///< path that the map was built from; its digest where only the blob is known
  std::string source_sha256;  ///< 64 hexadecimal digits
  std::string crc32;          ///< 8 hexadecimal digits
  double resolution = 0;
  double unit = 0;  ///< resolution of the blob's integers
  double radius = 0;
  UnknownPolicy unknown = UnknownPolicy::kAvoid;
  std::array<double, 6> bounds{};  ///< low, then high corner
  std::size_t cells = 0;
  std::size_t windows = 0;
  std::size_t degree_max = 0;  ///< most windows of one cell
  std::size_t blob_bytes = 0;
  std::array<std::size_t, kBlobSectionCount> section_bytes{};  ///< records without their landmark distances
  std::size_t landmarks = 0;                                   ///< distances stored with each window of the largest
                                                               ///< component
  std::size_t landmark_bytes = 0;
  bool landmarks_too_far = false;  ///< none, because ways are too long for the blob's integers; known to the builder
  bool searched_over_centres = false;  ///< the default search sees windows at their centres and uses the landmarks
  double free_volume = 0;              ///< [m^3]
  double lost_to_inflation = 0;        ///< [m^3] known free space too close to obstacles
  double lost_to_unknown = 0;          ///< [m^3] that policy `free` would leave free and this one does not
  double lost_to_coarsening = 0;       ///< [m^3]
  double lost_to_slivers = 0;          ///< [m^3]
  double worst_loss =
      0;  ///< a free point farther than radius + this from all obstacles is in a cell (before coarsening and slivers)
  std::size_t components = 0;
  double largest_component = 0;                          ///< share of the free volume, 0 to 1
  std::array<double, 3> largest_component_point{};       ///< a free point of it; zero without cells
  std::vector<BoardFit> boards;                          ///< which of them can hold the map
  std::optional<std::vector<Alternative>> alternatives;  ///< tried on a map in pieces, where its source was at hand
};

/// Everything that the blob alone can tell.
MapReport map_info(const BoxGraphView& view);

nlohmann::ordered_json map_report_json(const MapReport& report);

/// "avoid", "occupied" or "free".
const char* describe(UnknownPolicy policy);

}  // namespace swiftlet::tools
