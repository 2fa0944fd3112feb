#include <gtest/gtest.h>

#include <cstdlib>

#include "no_heap/heap_guard.hpp"
#include "unit/test_blob.hpp"

namespace {

using swiftlet::BoxGraphView;
using swiftlet::test::HeapGuard;
using swiftlet::test::TestBlob;

void* volatile sink = nullptr;  // an allocation that nobody sees may be removed

TEST(HeapGuardDeathTest, malloc_aborts_under_a_guard) {
  EXPECT_DEATH(
      {
        const HeapGuard guard;
        sink = std::malloc(8);
      },
      "heap was used");
}

TEST(HeapGuardDeathTest, new_aborts_under_a_guard) {
  EXPECT_DEATH(
      {
        const HeapGuard guard;
        sink = new double;
      },
      "heap was used");
}

TEST(HeapGuardDeathTest, free_aborts_under_a_guard) {
  sink = std::malloc(8);
  EXPECT_DEATH(
      {
        const HeapGuard guard;
        std::free(sink);
      },
      "heap was used");
  std::free(sink);
}

TEST(HeapGuard, allocation_is_allowed_again_after_the_guard) {
  { const HeapGuard guard; }
  sink = std::malloc(8);
  EXPECT_NE(sink, nullptr);
  std::free(sink);
}

TEST(NoHeap, a_blob_is_opened_and_searched_without_the_heap) {
  TestBlob blob({20, 10, 10}, {{{0, 0, 0}, {10, 10, 10}}, {{10, 2, 2}, {20, 8, 8}}});
  const std::span<const std::byte> bytes = blob.bytes();
  bool found = false;
  {
    const HeapGuard guard;
    const swiftlet::Result<BoxGraphView> view = BoxGraphView::open(bytes);
    found = view.ok() && view->locate({15, 5, 5}).has_value() && view->nearest_free({15, 9, 9}).has_value();
  }
  EXPECT_TRUE(found);
}

}  // namespace
