#include "map/audit.hpp"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <limits>
#include <map>
#include <span>

#include "map/box_tree.hpp"
#include "map/obstacles.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kElevenDigits =
    1e-11;  // relative: a squared distance that equals the squared radius so far is no less

GridBox to_grid_box(const IntBox& box) {
  return {{box.lo[0], box.lo[1], box.lo[2]}, {box.hi[0], box.hi[1], box.hi[2]}};
}

/// The parts of `region` that none of the boxes covers, by halving it until a part is empty or full.
void find_uncovered(const GridBox& region, std::span<const GridBox> boxes, std::vector<GridBox>& uncovered) {
  std::vector<GridBox> inside;
  std::uint64_t covered = 0;
  for (const GridBox& box : boxes) {
    const GridBox common = intersection(box, region);
    if (volume(common) == 0) continue;
    inside.push_back(common);
    covered += volume(common);
  }
  if (covered == 0) uncovered.push_back(region);
  if (covered == 0 || covered >= volume(region)) return;
  std::size_t axis = 0;
  for (const std::size_t other : {1U, 2U}) {
    if (region.hi[other] - region.lo[other] > region.hi[axis] - region.lo[axis]) axis = other;
  }
  GridBox low = region;
  GridBox high = region;
  low.hi[axis] = high.lo[axis] = (region.lo[axis] + region.hi[axis]) / 2;
  find_uncovered(low, inside, uncovered);
  find_uncovered(high, inside, uncovered);
}

bool shares_window(const GridBox& a, const GridBox& b) {
  int touching = 0;
  int overlapping = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t length = std::min(a.hi[axis], b.hi[axis]) - std::max(a.lo[axis], b.lo[axis]);
    touching += length == 0 ? 1 : 0;
    overlapping += length > 0 ? 1 : 0;
  }
  return touching == 1 && overlapping == 2;
}

class Audit {
 public:
  Audit(const BoxGraphView& view, const VoxelMap& map, const Progress& progress)
      : view_(view), header_(view.header()), map_(map), progress_(progress) {}

  AuditReport run() {
    if (!check_source()) return std::move(report_);  // nothing below would mean anything
    collect();
    check_cells();
    check_cover();
    check_graph();
    check_landmarks();
    check_obstacles();
    return std::move(report_);
  }

 private:
  [[gnu::format(printf, 2, 3)]] void defect(const char* format, ...) {
    constexpr std::size_t kMaxFindings = 20;
    ++report_.defects;
    if (report_.findings.size() >= kMaxFindings) return;
    std::array<char, 400> line{};
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(line.data(), line.size(), format, arguments);
    va_end(arguments);
    report_.findings.emplace_back(line.data());
  }

  /// "(x, y, z) to (x, y, z)" in metres.
  [[nodiscard]] std::string where(const GridBox& box) const {
    std::array<double, 6> m{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      m[axis] = header_.origin[axis] + view_.unit() * box.lo[axis];
      m[axis + 3] = header_.origin[axis] + view_.unit() * box.hi[axis];
    }
    std::array<char, 200> text{};
    std::snprintf(text.data(), text.size(), "(%.9g, %.9g, %.9g) to (%.9g, %.9g, %.9g)", m[0], m[1], m[2], m[3], m[4],
                  m[5]);
    return text.data();
  }

  bool check_source() {
    if (header_.source_digest != map_.source_digest) {
      defect("the map was built from another file than this one (their SHA-256 differ)");
    }
    if (header_.resolution != map_.resolution) {
      defect("the resolution is %.9g m, the source has %.9g m", header_.resolution, map_.resolution);
      return false;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double voxels = (header_.origin[axis] - map_.origin[axis]) / map_.resolution;
      first_voxel_[axis] = std::llround(std::clamp(voxels, -1.0, 1e6));
      const std::int64_t end = (first_voxel_[axis] << header_.unit_shift) + header_.size[axis];
      const bool inside = first_voxel_[axis] >= 0 && end <= std::int64_t{map_.size[axis]} << header_.unit_shift;
      if (std::abs(voxels - static_cast<double>(first_voxel_[axis])) > 1e-6 || !inside) {
        defect("the mapped box does not lie on the voxels of the source on axis %zu", axis);
        return false;
      }
    }
    return true;
  }

  [[nodiscard]] std::int32_t to_unit(std::size_t axis, std::int64_t voxel) const {
    return static_cast<std::int32_t>((voxel - first_voxel_[axis]) * (std::int64_t{1} << header_.unit_shift));
  }

  /// Everything in units of the blob: obstacles that keep their distance, space that no cell may enter, space that may
  /// be free.
  void collect() {
    const double radius_units = header_.radius / view_.unit();
    limit_ = radius_units * radius_units * (1 - kElevenDigits);
    const auto margin = static_cast<std::int32_t>(std::min(radius_units, 1e6)) + 1;
    GridBox near = mapped_box();  // what is farther away blocks nothing
    GridBox source{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      near.lo[axis] -= margin;
      near.hi[axis] += margin;
      source.lo[axis] = to_unit(axis, 0);
      source.hi[axis] = to_unit(axis, map_.size[axis]);
    }
    near = intersection(near, source);

    std::vector<GridBox> occupied;
    std::vector<GridBox> known;
    for (const VoxelLeaf& leaf : map_.leaves) {
      GridBox box{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lo[axis] = to_unit(axis, leaf.lo[axis]);
        box.hi[axis] = to_unit(axis, leaf.lo[axis] + (std::int64_t{1} << leaf.log2_edge));
      }
      if (volume(intersection(box, near)) == 0) continue;
      known.push_back(box);
      (leaf.occupied ? occupied : candidates_).push_back(box);
    }
    std::vector<GridBox> unknown;
    find_uncovered(near, known, unknown);
    known = {};  // the largest of them all in a big map
    progress_("verify: read", 1);

    const auto policy = static_cast<UnknownPolicy>(header_.unknown_policy);
    occupied_ = BoxTree(occupied);
    if (policy == UnknownPolicy::kFree) candidates_.insert(candidates_.end(), unknown.begin(), unknown.end());
    if (policy == UnknownPolicy::kOccupied) occupied.insert(occupied.end(), unknown.begin(), unknown.end());
    if (policy != UnknownPolicy::kFree) unknown_ = BoxTree(std::move(unknown));
    inflated_ = BoxTree(std::move(occupied));

    std::vector<GridBox> cells;
    for (std::size_t i = 0; i < view_.cell_count(); ++i) {
      cells.push_back(to_grid_box(view_.cell(static_cast<CellIndex>(i))));
    }
    cells_ = BoxTree(std::move(cells));
  }

  [[nodiscard]] GridBox mapped_box() const {
    const auto size = [this](std::size_t axis) { return static_cast<std::int32_t>(header_.size[axis]); };
    return {{0, 0, 0}, {size(0), size(1), size(2)}};
  }

  /// Disjoint, far enough from obstacles, free of forbidden space; extents in the union; location finds them.
  void check_cells() {
    for (std::size_t i = 0; i < cells_.boxes().size(); ++i) {
      const GridBox& box = cells_.boxes()[i];
      const std::size_t number = cells_.original(i);
      const auto index = static_cast<CellIndex>(number);
      if (cells_.common_volume(box) != volume(box)) {
        defect("cell %zu, %s, overlaps another", number, where(box).c_str());
      }
      const std::size_t obstacle = inflated_.find_closer(box, limit_, BoxTree::kNone);
      if (obstacle != BoxTree::kNone) {
        const GridBox& other = inflated_.boxes()[obstacle];
        defect("cell %zu, %s, is %.9g m from the obstacle %s, less than the radius", number, where(box).c_str(),
               view_.unit() * std::sqrt(static_cast<double>(squared_gap(box, other))), where(other).c_str());
      }
      if (occupied_.common_volume(box) > 0) defect("cell %zu, %s, lies in an obstacle", number, where(box).c_str());
      if (unknown_.common_volume(box) > 0) defect("cell %zu, %s, lies in unknown space", number, where(box).c_str());

      const GridBox extent = to_grid_box(view_.extent(index));
      const bool in_cells = cells_.common_volume(extent) == volume(extent);
      if (!in_cells && !(header_.lost_to_slivers > 0 && is_free(extent))) {
        defect("the extent of cell %zu, %s, leaves the free space", number, where(extent).c_str());
      }
      const Box world = view_.to_world(view_.cell(index));
      const Vector3 middle = (world.lo + world.hi) / 2;
      if (view_.locate(middle) != index) defect("the index does not find cell %zu, %s", number, where(box).c_str());
      if (i % 1024 == 0) progress_("verify: cells", static_cast<double>(i) / static_cast<double>(view_.cell_count()));
    }
  }

  /// The rules of the source alone, for extents that reach into dropped cells.
  [[nodiscard]] bool is_free(const GridBox& box) const {
    return intersection(box, mapped_box()) == box &&
           inflated_.find_closer(box, limit_, BoxTree::kNone) == BoxTree::kNone && occupied_.common_volume(box) == 0 &&
           unknown_.common_volume(box) == 0;
  }

  /// Every unit cube that is free lies in a cell, but for what the header says was dropped.
  void check_cover() {
    std::uint64_t missing = 0;
    GridBox first_missing{};
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const GridBox region = intersection(candidates_[i], mapped_box());
      missing += missing_in(region, first_missing);
      if (i % 4096 == 0) {
        progress_("verify: cover", static_cast<double>(i) / static_cast<double>(candidates_.size()));
      }
    }
    const std::uint64_t dropped = header_.lost_to_coarsening + header_.lost_to_slivers;
    if (missing == dropped) return;
    const double cubic = view_.unit() * view_.unit() * view_.unit();
    defect("%.9g m3 of free space lie in no cell, the map says %.9g m3; one place is %s",
           cubic * static_cast<double>(missing), cubic * static_cast<double>(dropped), where(first_missing).c_str());
  }

  /// Free volume of the region that no cell covers. Parts that are covered, or wholly near one obstacle, are dealt with
  /// at once; the rest is halved down to unit cubes.
  std::uint64_t missing_in(const GridBox& region, GridBox& first_missing) {
    if (volume(region) == 0) return 0;
    const std::uint64_t covered = cells_.common_volume(region);
    if (covered >= volume(region)) return 0;
    hint_ = inflated_.find_closer(region, limit_, hint_);
    if (hint_ == BoxTree::kNone && covered == 0) {
      first_missing = region;
      return volume(region);
    }
    if (hint_ != BoxTree::kNone && is_wholly_near(region, inflated_.boxes()[hint_])) return 0;
    std::size_t axis = 0;
    for (const std::size_t other : {1U, 2U}) {
      if (region.hi[other] - region.lo[other] > region.hi[axis] - region.lo[axis]) axis = other;
    }
    if (region.hi[axis] - region.lo[axis] == 1) return 0;  // a unit cube with an obstacle near one of its points
    GridBox low = region;
    GridBox high = region;
    low.hi[axis] = high.lo[axis] = (region.lo[axis] + region.hi[axis]) / 2;
    return missing_in(low, first_missing) + missing_in(high, first_missing);
  }

  /// True when every unit cube of the region is closer to the box than the radius.
  [[nodiscard]] bool is_wholly_near(const GridBox& region, const GridBox& box) const {
    double farthest = 0;  // of the cubes' gaps, reached in a corner of the region
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int32_t gap = std::max({0, region.hi[axis] - 1 - box.hi[axis], box.lo[axis] - region.lo[axis] - 1});
      farthest += static_cast<double>(gap) * gap;
    }
    return farthest < limit_;
  }

  /// Neighbours are exactly the cells that share a window; labels are those of a flood over them.
  void check_graph() {
    const std::size_t count = view_.cell_count();
    std::vector<CellIndex> expected;
    for (std::size_t i = 0; i < count; ++i) {
      const GridBox& box = cells_.boxes()[i];
      expected.clear();
      cells_.for_each_touching(box, [&](std::size_t j) {
        if (shares_window(box, cells_.boxes()[j])) expected.push_back(static_cast<CellIndex>(cells_.original(j)));
      });
      std::sort(expected.begin(), expected.end());
      const NeighbourRange row = view_.neighbours(static_cast<CellIndex>(cells_.original(i)));
      if (!std::equal(row.begin(), row.end(), expected.begin(), expected.end())) {
        defect("cell %zu, %s, lists %zu windows, not the %zu that it has", cells_.original(i), where(box).c_str(),
               row.size(), expected.size());
      }
      if (i % 1024 == 0) progress_("verify: windows", static_cast<double>(i) / static_cast<double>(count));
    }

    std::vector<bool> reached(count);
    std::vector<bool> label_used(header_.component_count);
    std::vector<CellIndex> stack;
    for (std::size_t seed = 0; seed < count; ++seed) {
      if (reached[seed]) continue;
      const std::uint16_t label = view_.component(static_cast<CellIndex>(seed));
      if (label_used[label] && label != kMostComponentLabels - 1)
        defect("component %u is not connected", unsigned{label});
      label_used[label] = true;
      reached[seed] = true;
      stack.push_back(static_cast<CellIndex>(seed));
      while (!stack.empty()) {
        const CellIndex cell = stack.back();
        stack.pop_back();
        for (const CellIndex next : view_.neighbours(cell)) {
          if (reached[to_size(next)]) continue;
          reached[to_size(next)] = true;
          stack.push_back(next);
        }
      }
    }
    if (std::count(label_used.begin(), label_used.end(), false) > 0) defect("a component label has no cell");
  }

  /// Every stored distance is that from the window where the landmark's own distance is zero, over window centres,
  /// rounded: then the search's bounds are admissible. By relaxation in the order of buckets one unit wide.
  void check_landmarks() {
    if (!view_.has_landmarks(0)) return;
    std::vector<AuditWindow> windows;
    std::vector<std::vector<std::uint32_t>> of_cell(view_.cell_count());
    for (std::size_t i = 0; i < view_.cell_count(); ++i) {
      const auto cell = static_cast<CellIndex>(i);
      if (view_.component(cell) != 0) continue;
      for (const CellIndex next : view_.neighbours(cell)) {
        if (next < cell) continue;
        const IntBox a = view_.cell(cell);
        const IntBox b = view_.cell(next);
        AuditWindow window{{}, cell, next, 0};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          window.centre[axis] = (std::max(a.lo[axis], b.lo[axis]) + std::min(a.hi[axis], b.hi[axis])) / 2.0;
        }
        of_cell[i].push_back(static_cast<std::uint32_t>(windows.size()));
        of_cell[to_size(next)].push_back(static_cast<std::uint32_t>(windows.size()));
        windows.push_back(window);
      }
    }
    for (std::size_t k = 0; k < header_.landmark_count; ++k) {
      check_landmark(k, windows, of_cell);
      progress_("verify: landmarks", static_cast<double>(k + 1) / header_.landmark_count);
    }
  }

  struct AuditWindow {
    std::array<double, 3> centre;
    CellIndex a, b;
    double distance;  ///< [unit] from the landmark under way
  };

  void check_landmark(std::size_t k, std::vector<AuditWindow>& windows,
                      const std::vector<std::vector<std::uint32_t>>& of_cell) {
    const double step = 1.0 / static_cast<double>(1U << header_.landmark_shift);
    std::map<std::int64_t, std::vector<std::uint32_t>> buckets;
    for (std::uint32_t i = 0; i < windows.size(); ++i) {
      const bool is_landmark = view_.landmarks(windows[i].a, windows[i].b)[k] == 0;
      windows[i].distance = is_landmark ? 0 : std::numeric_limits<double>::infinity();
      if (is_landmark) buckets[0].push_back(i);
    }
    if (buckets.empty() || buckets[0].size() != 1) {
      return defect("landmark %zu lies at %zu windows, not at one", k, buckets.empty() ? 0 : buckets[0].size());
    }
    while (!buckets.empty()) {
      std::vector<std::uint32_t> bucket = std::move(buckets.begin()->second);
      buckets.erase(buckets.begin());
      for (std::size_t next = 0; next < bucket.size(); ++next) {
        const AuditWindow here = windows[bucket[next]];
        for (const CellIndex cell : {here.a, here.b}) {
          for (const std::uint32_t i : of_cell[to_size(cell)]) {
            const double distance =
                here.distance + std::hypot(windows[i].centre[0] - here.centre[0], windows[i].centre[1] - here.centre[1],
                                           windows[i].centre[2] - here.centre[2]);
            if (distance >= windows[i].distance) continue;
            windows[i].distance = distance;
            buckets[static_cast<std::int64_t>(distance)].push_back(i);
          }
        }
      }
    }
    for (const AuditWindow& window : windows) {
      const std::uint16_t stored = view_.landmarks(window.a, window.b)[k];
      if (std::abs(step * stored - window.distance) <= step * 0.501) continue;
      return defect("the window between cells %zu and %zu is %.9g units from landmark %zu, the map says %.9g",
                    to_size(window.a), to_size(window.b), window.distance, k, step * stored);
    }
  }

  void check_obstacles() {
    const Expected<std::vector<IntBox>> boxes = obstacle_boxes(view_);
    if (!boxes) return defect("%s", boxes.error().message.c_str());
    std::uint64_t sum = 0;
    for (const IntBox& obstacle : *boxes) {
      const GridBox box = to_grid_box(obstacle);
      sum += volume(box);
      if (occupied_.common_volume(box) != volume(box)) {
        return defect("the stored obstacle %s is not occupied", where(box).c_str());
      }
    }
    if (sum != occupied_.common_volume(mapped_box())) defect("the stored obstacles are not all of the source's");
  }

  const BoxGraphView& view_;
  const BlobHeader& header_;
  const VoxelMap& map_;
  const Progress& progress_;
  AuditReport report_;
  std::array<std::int64_t, 3> first_voxel_{};
  double limit_ = 0;  ///< [unit^2] squared distance below which an obstacle is too close
  BoxTree occupied_{{}};
  BoxTree inflated_{{}};  ///< what cells keep their distance from
  BoxTree unknown_{{}};   ///< what cells must not enter; empty under policy `free`
  BoxTree cells_{{}};
  std::vector<GridBox> candidates_;  ///< disjoint: all that may be free
  std::size_t hint_ = BoxTree::kNone;
};

}  // namespace

AuditReport audit_map(const BoxGraphView& view, const VoxelMap& map, const Progress& progress) {
  return Audit(view, map, progress).run();
}

}  // namespace swiftlet::tools
