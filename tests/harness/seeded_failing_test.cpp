#include "swiftlet_test.hpp"

TEST(Seeded, Fails) {
  EXPECT_EQ(1, 2);
  ASSERT_TRUE(false);
  EXPECT_EQ(3, 4);  // not reached
}

TEST(Seeded, Passes) { EXPECT_EQ(-7, -7); }
