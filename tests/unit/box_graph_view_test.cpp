#include "swiftlet/box_graph_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "swiftlet_test.hpp"
#include "test_blob.hpp"

namespace {

using swiftlet::BlobBox;
using swiftlet::BlobSection;
using swiftlet::Box;
using swiftlet::BoxGraphView;
using swiftlet::CellIndex;
using swiftlet::IntBox;
using swiftlet::Real;
using swiftlet::Status;
using swiftlet::Vector3;
using swiftlet::test::TestBlob;

/// Three cells in a row along x, the middle one twice as high, and one apart from them.
TestBlob four_cells() {
  return {{10, 4, 4},
          {IntBox{{0, 0, 0}, {2, 2, 2}}, IntBox{{2, 0, 0}, {4, 2, 4}}, IntBox{{4, 0, 0}, {6, 2, 2}},
           IntBox{{8, 2, 2}, {10, 4, 4}}}};
}

/// A checkerboard of 2 x 2 x 2 blocks, 32 of 64: every edge is shared and no face is; enough for a tree of 7 nodes.
TestBlob checkerboard() {
  std::array<IntBox, 32> boxes{};
  std::size_t count = 0;
  for (std::uint16_t x = 0; x < 4; ++x) {
    for (std::uint16_t y = 0; y < 4; ++y) {
      for (std::uint16_t z = 0; z < 4; ++z) {
        if ((x + y + z) % 2 != 0) continue;
        const auto corner = [](int a, int b, int c) {
          return std::array<std::uint16_t, 3>{static_cast<std::uint16_t>(a), static_cast<std::uint16_t>(b),
                                              static_cast<std::uint16_t>(c)};
        };
        boxes[count++] = {corner(2 * x, 2 * y, 2 * z), corner(2 * x + 2, 2 * y + 2, 2 * z + 2)};
      }
    }
  }
  TestBlob blob({8, 8, 8}, boxes, 0.1);
  blob.set_origin({-0.37, 100.2, 3});
  return blob;
}

std::optional<CellIndex> locate_by_brute_force(const BoxGraphView& view, const Vector3& p) {
  for (std::size_t i = 0; i < view.cell_count(); ++i) {
    const Box box = view.to_world(view.cell(static_cast<CellIndex>(i)));
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) inside = inside && p[axis] >= box.lo[axis] && p[axis] <= box.hi[axis];
    if (inside) return static_cast<CellIndex>(i);
  }
  return std::nullopt;
}

Real distance_to_box(const Box& box, const Vector3& p) {
  Real squared = 0;
  for (int axis = 0; axis < 3; ++axis) {
    Real gap = 0;
    if (p[axis] < box.lo[axis]) gap = box.lo[axis] - p[axis];
    if (p[axis] > box.hi[axis]) gap = p[axis] - box.hi[axis];
    squared += gap * gap;
  }
  return std::sqrt(squared);
}

Status status_of(TestBlob& blob) { return BoxGraphView::open(blob.bytes()).status(); }

TEST(BoxGraphView, ReadsBackWhatWasWritten) {
  TestBlob blob = four_cells();
  ASSERT_EQ(status_of(blob), Status::kOk);
  const BoxGraphView view = blob.view();
  EXPECT_EQ(view.cell_count(), 4U);
  EXPECT_TRUE(view.cell(CellIndex{1}) == (IntBox{{2, 0, 0}, {4, 2, 4}}));
  const auto row = view.neighbours(CellIndex{1});
  const std::array<CellIndex, 2> expected{CellIndex{0}, CellIndex{2}};
  EXPECT_EQ(row.size(), 2U);
  EXPECT_TRUE(std::equal(row.begin(), row.end(), expected.begin(), expected.end()));
  EXPECT_TRUE(view.neighbours(CellIndex{3}).empty());
  EXPECT_EQ(view.component(CellIndex{2}), view.component(CellIndex{0}));
  EXPECT_NE(view.component(CellIndex{3}), view.component(CellIndex{0}));
  EXPECT_EQ(view.bytes().size(), blob.bytes().size());
  EXPECT_TRUE(view.obstacles().empty());
}

TEST(BoxGraphView, TheChecksumIsTheOneOfZlib) {
  // zlib.crc32 of 224 bytes that are zero but for 'swiftlet' at the front, as computed by Python's zlib.
  alignas(8) std::array<std::byte, sizeof(swiftlet::BlobHeader)> bytes{};
  std::memcpy(bytes.data(), "swiftlet", 8);
  EXPECT_EQ(swiftlet::blob_crc32(bytes), 0x6946280DU);
}

TEST(BoxGraphView, AMapWithoutCellsIsValidAndHoldsNothing) {
  TestBlob blob({5, 5, 5}, {});
  ASSERT_EQ(status_of(blob), Status::kOk);
  EXPECT_FALSE(blob.view().locate(Vector3(1, 1, 1)).has_value());
  EXPECT_FALSE(blob.view().nearest_free(Vector3(1, 1, 1)).has_value());
  EXPECT_EQ(blob.view().covered_volume({{0, 0, 0}, {5, 5, 5}}), 0U);
}

TEST(BoxGraphView, LandmarkDistancesAreThoseOfTheWindowWhicheverSideAsks) {
  // Three cells in a row: windows at x = 2 and x = 3.
  TestBlob blob({4, 2, 1}, {{{0, 0, 0}, {2, 2, 1}}, {{2, 0, 0}, {3, 2, 1}}, {{3, 0, 0}, {4, 2, 1}}});
  EXPECT_FALSE(blob.view().has_landmarks(0));
  blob.set_landmarks(2);
  ASSERT_EQ(status_of(blob), Status::kOk);
  const BoxGraphView graph = blob.view();
  ASSERT_TRUE(graph.has_landmarks(0));
  EXPECT_FALSE(graph.has_landmarks(1));
  for (const bool swapped : {false, true}) {
    const CellIndex middle{1};
    const CellIndex first{0};
    const CellIndex last{2};
    const auto near = swapped ? graph.landmarks(middle, first) : graph.landmarks(first, middle);
    const auto far = swapped ? graph.landmarks(last, middle) : graph.landmarks(middle, last);
    EXPECT_EQ(near[0], 0);
    EXPECT_EQ(near[1], 256);  // one unit, the shift being eight
    EXPECT_EQ(far[0], 256);
    EXPECT_EQ(far[1], 0);
  }
}

TEST(BoxGraphView, RefusesEveryTruncation) {
  TestBlob blob = four_cells();
  for (std::size_t length = 0; length < blob.bytes().size(); ++length) {
    EXPECT_EQ(BoxGraphView::open(blob.bytes().first(length)).status(), Status::kBlobTruncated);
  }
}

TEST(BoxGraphView, RefusesEverySingleFlippedBit) {
  TestBlob blob = four_cells();
  for (std::size_t bit = 0; bit < 8 * blob.bytes().size(); ++bit) {
    const auto mask = static_cast<std::byte>(1U << (bit % 8));
    blob.bytes()[bit / 8] ^= mask;
    EXPECT_NE(status_of(blob), Status::kOk);
    blob.bytes()[bit / 8] ^= mask;
  }
  EXPECT_EQ(status_of(blob), Status::kOk);
}

TEST(BoxGraphView, SaysWhatIsWrongWithAForeignHeader) {
  TestBlob blob = four_cells();
  EXPECT_EQ(BoxGraphView::open(blob.bytes().subspan(4)).status(), Status::kBadRequest);
  blob.header().magic[0] = 's';
  EXPECT_EQ(status_of(blob), Status::kBlobWrongMagic);
  blob = four_cells();
  blob.header().byte_order = 0x04030201;
  blob.seal();
  EXPECT_EQ(status_of(blob), Status::kBlobWrongByteOrder);
  blob = four_cells();
  blob.header().version += 1;
  blob.seal();
  EXPECT_EQ(status_of(blob), Status::kBlobWrongVersion);
  blob = four_cells();
  blob.header().blob_bytes += 8;
  EXPECT_EQ(status_of(blob), Status::kBlobTruncated);
  blob = four_cells();
  blob.header().blob_bytes = 8;
  EXPECT_EQ(status_of(blob), Status::kBlobInconsistent);
  blob = four_cells();
  blob.header().radius = 1;
  EXPECT_EQ(status_of(blob), Status::kBlobDamaged);
}

/// Applies a change to a good blob, makes the checksum right and expects a refusal.
template <typename Change>
void expect_inconsistent(const Change& change) {
  TestBlob blob = four_cells();
  change(blob);
  blob.seal();
  EXPECT_EQ(status_of(blob), Status::kBlobInconsistent);
}

TEST(BoxGraphView, RefusesAHeaderThatContradictsItselfUnderARightChecksum) {
  expect_inconsistent([](TestBlob& b) { b.header().resolution = 0; });
  expect_inconsistent([](TestBlob& b) { b.header().resolution = std::numeric_limits<double>::quiet_NaN(); });
  expect_inconsistent([](TestBlob& b) { b.header().origin[2] = std::numeric_limits<double>::infinity(); });
  expect_inconsistent([](TestBlob& b) { b.header().resolution = 1e300; });
  expect_inconsistent([](TestBlob& b) { b.header().origin[0] = -1e300; });
  expect_inconsistent([](TestBlob& b) { b.header().radius = -0.5; });
  expect_inconsistent([](TestBlob& b) { b.header().radius = std::numeric_limits<double>::quiet_NaN(); });
  expect_inconsistent([](TestBlob& b) { b.header().unknown_policy = 3; });
  expect_inconsistent([](TestBlob& b) { b.header().unit_shift = 9; });
  expect_inconsistent([](TestBlob& b) { b.header().landmark_count = 33; });
  expect_inconsistent([](TestBlob& b) { b.header().landmark_count = 1; });  // without a shift, and without distances
  expect_inconsistent([](TestBlob& b) { b.header().landmark_shift = 1; });  // without landmarks
  expect_inconsistent([](TestBlob& b) { b.header().search_points = 2; });
  expect_inconsistent([](TestBlob& b) { b.header().size[1] = 0; });
  expect_inconsistent([](TestBlob& b) { b.header().size[1] = 65'536; });
  expect_inconsistent([](TestBlob& b) { b.header().cell_count = 5; });
  expect_inconsistent([](TestBlob& b) { b.header().cell_count = 0xFFFFFFFF; });
  expect_inconsistent([](TestBlob& b) { b.header().neighbour_count = 0x80000004; });
  expect_inconsistent([](TestBlob& b) { b.header().index_node_count = 3; });
  expect_inconsistent([](TestBlob& b) { b.header().component_count = 1; });
  for (std::size_t i = 0; i < swiftlet::kBlobSectionCount; ++i) {
    expect_inconsistent([i](TestBlob& b) { b.header().sections[i].offset += 8; });
    expect_inconsistent([i](TestBlob& b) { b.header().sections[i].bytes += 12; });
    expect_inconsistent([i](TestBlob& b) { b.header().sections[i].offset = 0xFFFFFFF8; });
  }
}

TEST(BoxGraphView, RefusesCellsAndExtentsOutOfPlaceUnderARightChecksum) {
  const auto cell = [](TestBlob& b, std::size_t i) -> BlobBox& { return b.section<BlobBox>(BlobSection::kCells)[i]; };
  expect_inconsistent([&](TestBlob& b) { cell(b, 3).hi[0] = cell(b, 3).lo[0]; });
  expect_inconsistent([&](TestBlob& b) { cell(b, 3).lo[2] = 4; });
  expect_inconsistent([&](TestBlob& b) { cell(b, 3).hi[1] = 5; });
  // The last cell spans (8, 2, 2) to (10, 4, 4) of (10, 4, 4): its extent may grow by 8, 2 and 2 below, by nothing
  // above.
  constexpr std::array<std::uint8_t, 6> kRoom{8, 2, 2, 0, 0, 0};
  for (std::size_t side = 0; side < 6; ++side) {
    const auto growth = [side](TestBlob& b) -> std::byte& {
      const auto& records = b.header().sections[static_cast<std::size_t>(BlobSection::kRecords)];
      return b.section<std::byte>(BlobSection::kRecords)[records.bytes - 6 + side];
    };
    TestBlob blob = four_cells();
    growth(blob) = static_cast<std::byte>(kRoom[side]);
    blob.seal();
    EXPECT_EQ(status_of(blob), Status::kOk);
    expect_inconsistent([&](TestBlob& b) { growth(b) = static_cast<std::byte>(kRoom[side] + 1); });
  }
}

TEST(BoxGraphView, ReadsAnExtentThatIsLargerThanItsCell) {
  TestBlob blob = four_cells();
  const IntBox extent{{3, 1, 0}, {10, 4, 4}};
  blob.set_extent(3, extent);
  ASSERT_EQ(status_of(blob), Status::kOk);
  EXPECT_TRUE(blob.view().extent(CellIndex{3}) == extent);
  EXPECT_TRUE(blob.view().extent(CellIndex{1}) == blob.view().cell(CellIndex{1}));
  TestBlob wide({60'000, 1, 1}, {IntBox{{30'000, 0, 0}, {30'001, 1, 1}}});
  wide.set_extent(0, {{1, 0, 0}, {60'000, 1, 1}});
  ASSERT_EQ(status_of(wide), Status::kOk);
  EXPECT_TRUE(wide.view().extent(CellIndex{0}) == (IntBox{{1, 0, 0}, {60'000, 1, 1}}));
}

TEST(BoxGraphView, RefusesABrokenAdjacencyUnderARightChecksum) {
  expect_inconsistent([](TestBlob& b) { b.set_adjacent(0, 0, true); });
  expect_inconsistent([](TestBlob& b) { b.set_adjacent(0, 2, true); });  // shares no window, and only one side says so
  expect_inconsistent([](TestBlob& b) {
    b.set_adjacent(0, 3, true);
    b.set_adjacent(3, 0, true);
  });
  expect_inconsistent([](TestBlob& b) { b.set_adjacent(0, 1, false); });
  expect_inconsistent([](TestBlob& b) { b.set_adjacent(1, 0, false); });
  expect_inconsistent([](TestBlob& b) { b.header().neighbour_count -= 1; });
  expect_inconsistent([](TestBlob& b) { b.section<std::uint16_t>(BlobSection::kComponents)[0] = 1; });
  expect_inconsistent([](TestBlob& b) { b.section<std::uint16_t>(BlobSection::kComponents)[3] = 2; });
}

TEST(BoxGraphView, RefusesRecordsThatDoNotFollowEachOtherUnderARightChecksum) {
  // Cell 0: one neighbour, +1, six growths of 0, so 8 bytes; cell 1 starts with 2 neighbours, -1, and a step of 2.
  const auto byte = [](TestBlob& b, std::size_t i) -> std::byte& {
    return b.section<std::byte>(BlobSection::kRecords)[i];
  };
  for (std::size_t i = 0; i < 4; ++i) {
    expect_inconsistent([i](TestBlob& b) { b.section<std::uint32_t>(BlobSection::kRecordOffsets)[i] += 1; });
    expect_inconsistent([i](TestBlob& b) { b.section<std::uint32_t>(BlobSection::kRecordOffsets)[i] = 0xFFFFFFFF; });
  }
  expect_inconsistent([&](TestBlob& b) { byte(b, 0) = std::byte{0}; });
  expect_inconsistent([&](TestBlob& b) { byte(b, 0) = std::byte{2}; });
  expect_inconsistent([&](TestBlob& b) { byte(b, 0) = std::byte{127}; });
  expect_inconsistent([&](TestBlob& b) { byte(b, 1) = std::byte{1}; });  // neighbour -1
  expect_inconsistent([&](TestBlob& b) { byte(b, 1) = std::byte{8}; });  // neighbour 4 of 4 cells
  expect_inconsistent([&](TestBlob& b) { byte(b, 10) = std::byte{127}; });
  // A number that never ends, at every place.
  const std::size_t bytes = four_cells().header().sections[static_cast<std::size_t>(BlobSection::kRecords)].bytes;
  for (std::size_t first = 0; first < bytes; ++first) {
    expect_inconsistent([&](TestBlob& b) {
      for (std::size_t i = first; i < bytes; ++i) byte(b, i) = std::byte{0xFF};
    });
  }
}

TEST(BoxGraphView, RefusesAnIndexThatDoesNotBoundItsCellsUnderARightChecksum) {
  expect_inconsistent([](TestBlob& b) { b.section<BlobBox>(BlobSection::kIndex)[0].hi[0] = 9; });
  expect_inconsistent([](TestBlob& b) { b.section<BlobBox>(BlobSection::kIndex)[0].hi[0] = 11; });
  TestBlob blob = checkerboard();
  ASSERT_EQ(status_of(blob), Status::kOk);
  for (std::size_t node = 0; node < 7; ++node) {
    blob = checkerboard();
    blob.section<BlobBox>(BlobSection::kIndex)[node].lo[2] += 1;
    blob.seal();
    EXPECT_EQ(status_of(blob), Status::kBlobInconsistent);
  }
}

TEST(BoxGraphView, LocatesPointsOnFacesEdgesAndCornersAsBruteForceDoes) {
  TestBlob blob = checkerboard();
  ASSERT_EQ(status_of(blob), Status::kOk);
  const BoxGraphView view = blob.view();
  std::size_t found = 0;
  for (std::uint16_t x = 0; x <= 8; ++x) {
    for (std::uint16_t y = 0; y <= 8; ++y) {
      for (std::uint16_t z = 0; z <= 8; ++z) {
        const Vector3 corner = view.to_world({{x, y, z}, {x, y, z}}).lo;
        const auto at_corner = view.locate(corner);
        ASSERT_TRUE(at_corner == locate_by_brute_force(view, corner));
        for (int axis = 0; axis < 3; ++axis) {
          // One step of the last bit beside the face on either side, and half a cell away.
          for (const Real target : {Real(-1e9), Real(1e9)}) {
            Vector3 p = corner;
            p[axis] = std::nextafter(p[axis], target);
            ASSERT_TRUE(view.locate(p) == locate_by_brute_force(view, p));
          }
          Vector3 p = corner;
          p[axis] += Real(0.05);
          ASSERT_TRUE(view.locate(p) == locate_by_brute_force(view, p));
        }
        found += at_corner ? 1U : 0U;
      }
    }
  }
  EXPECT_GT(found, 600U);  // of 729: all but the corners of the outer faces that belong to holes alone
  EXPECT_LT(found, 729U);
}

TEST(BoxGraphView, ThePointOnASharedFaceBelongsToTheLowerIndex) {
  TestBlob blob = four_cells();
  EXPECT_TRUE(blob.view().locate(Vector3(2, 1, 1)) == CellIndex{0});
  EXPECT_TRUE(blob.view().locate(Vector3(4, 1, 1)) == CellIndex{1});
}

TEST(BoxGraphView, LocatesNothingOutsideTheMapOrForNumbersThatAreNone) {
  TestBlob blob = four_cells();
  constexpr Real kNan = std::numeric_limits<Real>::quiet_NaN();
  constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    for (const Real value : {Real(-1), Real(11), kNan, kInfinity, -kInfinity, std::numeric_limits<Real>::max()}) {
      Vector3 p(1, 1, 1);
      p[axis] = value;
      EXPECT_FALSE(blob.view().locate(p).has_value());
    }
  }
}

TEST(BoxGraphView, FindsTheNearestFreePointOfOneComponent) {
  TestBlob blob({9, 2, 2}, {IntBox{{0, 0, 0}, {2, 2, 2}}, IntBox{{2, 0, 0}, {4, 2, 2}}, IntBox{{5, 0, 0}, {9, 2, 2}}});
  const BoxGraphView view = blob.view();
  const Vector3 p(Real(4.75), 1, 1);
  EXPECT_EQ(view.nearest_free(p)->cell, CellIndex{2});
  const auto nearest = view.nearest_free(p, view.component(CellIndex{0}));
  ASSERT_TRUE(nearest.has_value());
  EXPECT_EQ(nearest->cell, CellIndex{1});
  EXPECT_NEAR(nearest->distance, Real(0.75), Real(1e-6));
  EXPECT_FALSE(view.nearest_free(p, 7).has_value());
}

TEST(BoxGraphView, FindsTheNearestFreePointAsBruteForceDoes) {
  TestBlob blob = checkerboard();
  const BoxGraphView view = blob.view();
  for (int x = -3; x <= 11; ++x) {
    for (int y = -3; y <= 11; y += 2) {
      for (int z = -3; z <= 11; ++z) {
        const Vector3 p(Real(-0.33 + 0.1 * x), Real(100.25 + 0.1 * y), Real(3.07 + 0.1 * z));
        const auto nearest = view.nearest_free(p);
        ASSERT_TRUE(nearest.has_value());
        Real least = std::numeric_limits<Real>::infinity();
        for (std::size_t i = 0; i < view.cell_count(); ++i) {
          least = std::min(least, distance_to_box(view.to_world(view.cell(static_cast<CellIndex>(i))), p));
        }
        ASSERT_NEAR(nearest->distance, least, Real(1e-6));
        ASSERT_NEAR((nearest->point - p).norm(), least, Real(1e-6));
        ASSERT_EQ(distance_to_box(view.to_world(view.cell(nearest->cell)), nearest->point), Real(0));
        ASSERT_TRUE(view.locate(nearest->point).has_value());
      }
    }
  }
  EXPECT_FALSE(view.nearest_free(Vector3(0, std::numeric_limits<Real>::quiet_NaN(), 0)).has_value());
  EXPECT_TRUE(view.nearest_free(Vector3(0, std::numeric_limits<Real>::max(), 0)).has_value());
}

TEST(BoxGraphView, MeasuresHowMuchOfABoxIsFree) {
  TestBlob blob = checkerboard();
  const BoxGraphView view = blob.view();
  EXPECT_EQ(view.covered_volume({{0, 0, 0}, {8, 8, 8}}), 256U);
  EXPECT_EQ(view.covered_volume({{0, 0, 0}, {2, 2, 2}}), 8U);
  EXPECT_EQ(view.covered_volume({{1, 1, 1}, {3, 3, 3}}), 4U);
  EXPECT_EQ(view.covered_volume({{2, 0, 0}, {4, 2, 2}}), 0U);
  EXPECT_EQ(view.covered_volume({{2, 2, 2}, {2, 8, 8}}), 0U);
}

TEST(Status, DescribesPlansInTheWordsOfTheContract) {
  EXPECT_EQ(std::strcmp(swiftlet::describe(Status::kOk), "optimal"), 0);
  EXPECT_EQ(std::strcmp(swiftlet::describe(Status::kFallback), "fallback"), 0);
  EXPECT_EQ(std::strcmp(swiftlet::describe(Status::kStartNotFree), "start_not_free"), 0);
  EXPECT_EQ(std::strcmp(swiftlet::describe(Status::kGoalNotFree), "goal_not_free"), 0);
  EXPECT_EQ(std::strcmp(swiftlet::describe(Status::kNoPath), "no_path"), 0);
  EXPECT_EQ(std::strcmp(swiftlet::describe(Status::kSearchCapacity), "search_capacity"), 0);
  EXPECT_EQ(std::strcmp(swiftlet::describe(Status::kCorridorCapacity), "corridor_capacity"), 0);
  EXPECT_EQ(std::strcmp(swiftlet::describe(Status::kInfeasible), "infeasible"), 0);
  EXPECT_EQ(std::strcmp(swiftlet::describe(Status::kBadRequest), "bad_request"), 0);
}

}  // namespace
