#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

/// A test harness without a heap: cases register themselves in an intrusive list before main, run in the order of
/// registration, and print nothing unless they fail. Zero cases run is a failure.
namespace swiftlet::test {

/// One TEST, a static object.
class Case {
 public:
  Case(std::string_view suite, std::string_view name, void (*body)());
  [[nodiscard]] std::string_view suite() const { return suite_; }
  [[nodiscard]] std::string_view name() const { return name_; }
  [[nodiscard]] const Case* next() const { return next_; }
  void run() const { body_(); }

 private:
  std::string_view suite_;
  std::string_view name_;
  void (*body_)();
  Case* next_ = nullptr;
};

/// Runs every case; prints `N passed, N failed`; returns the exit status.
int run_cases();

/// Console output, and the way a number is shown: integers in decimal, floating point as its bits.
void print(std::string_view text);
void print_integer(std::int64_t value);
void print_bits(double value);

/// Counts a failure of the running case and prints where it is.
void fail(const char* file, int line, std::string_view claim);

template <typename T>
void print_value(const T& value) {
  if constexpr (std::is_floating_point_v<T>) {
    print_bits(static_cast<double>(value));
  } else if constexpr (std::is_integral_v<T> || std::is_enum_v<T>) {
    print_integer(static_cast<std::int64_t>(value));
  } else {
    print("(not shown)");
  }
}

/// Both sides of a claim that does not hold.
template <typename A, typename B>
void fail_pair(const char* file, int line, std::string_view claim, const A& left, const B& right) {
  fail(file, line, claim);
  print("  left ");
  print_value(left);
  print(", right ");
  print_value(right);
  print("\n");
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-compare"  // EXPECT_EQ(size, 3), as GoogleTest takes it
struct Equal {
  static bool holds(const auto& a, const auto& b) { return a == b; }
};
struct NotEqual {
  static bool holds(const auto& a, const auto& b) { return a != b; }
};
struct Less {
  static bool holds(const auto& a, const auto& b) { return a < b; }
};
struct LessEqual {
  static bool holds(const auto& a, const auto& b) { return a <= b; }
};
struct Greater {
  static bool holds(const auto& a, const auto& b) { return a > b; }
};
struct GreaterEqual {
  static bool holds(const auto& a, const auto& b) { return a >= b; }
};
#pragma GCC diagnostic pop

template <typename Relation, typename A, typename B>
bool check(const char* file, int line, std::string_view claim, const A& left, const B& right) {
  if (Relation::holds(left, right)) return true;
  fail_pair(file, line, claim, left, right);
  return false;
}

/// False for NaN.
inline bool check_near(const char* file, int line, std::string_view claim, double left, double right,
                       double tolerance) {
  const double distance = left > right ? left - right : right - left;
  if (distance <= tolerance || left == right) return true;
  fail_pair(file, line, claim, left, right);
  return false;
}

inline bool check_true(const char* file, int line, std::string_view claim, bool holds) {
  if (!holds) fail(file, line, claim);
  return holds;
}

}  // namespace swiftlet::test

#define TEST(suite, name)                                                                         \
  static void suite##_##name##_body();                                                            \
  static const swiftlet::test::Case suite##_##name##_case(#suite, #name, &suite##_##name##_body); \
  static void suite##_##name##_body()

#define SWIFTLET_CHECK(Relation, a, b) \
  swiftlet::test::check<swiftlet::test::Relation>(__FILE__, __LINE__, #Relation "(" #a ", " #b ")", a, b)
#define SWIFTLET_CHECK_NEAR(a, b, tolerance)                                                     \
  swiftlet::test::check_near(__FILE__, __LINE__, "Near(" #a ", " #b ")", static_cast<double>(a), \
                             static_cast<double>(b), static_cast<double>(tolerance))
#define SWIFTLET_CHECK_TRUE(a) swiftlet::test::check_true(__FILE__, __LINE__, #a, static_cast<bool>(a))
#define SWIFTLET_CHECK_FALSE(a) swiftlet::test::check_true(__FILE__, __LINE__, "not " #a, !static_cast<bool>(a))

#define EXPECT_TRUE(a) static_cast<void>(SWIFTLET_CHECK_TRUE(a))
#define EXPECT_FALSE(a) static_cast<void>(SWIFTLET_CHECK_FALSE(a))
#define EXPECT_EQ(a, b) static_cast<void>(SWIFTLET_CHECK(Equal, a, b))
#define EXPECT_NE(a, b) static_cast<void>(SWIFTLET_CHECK(NotEqual, a, b))
#define EXPECT_LT(a, b) static_cast<void>(SWIFTLET_CHECK(Less, a, b))
#define EXPECT_LE(a, b) static_cast<void>(SWIFTLET_CHECK(LessEqual, a, b))
#define EXPECT_GT(a, b) static_cast<void>(SWIFTLET_CHECK(Greater, a, b))
#define EXPECT_GE(a, b) static_cast<void>(SWIFTLET_CHECK(GreaterEqual, a, b))
#define EXPECT_NEAR(a, b, tolerance) static_cast<void>(SWIFTLET_CHECK_NEAR(a, b, tolerance))

#define SWIFTLET_OR_RETURN(holds) \
  if (holds) {                    \
  } else                          \
    return
#define ASSERT_TRUE(a) SWIFTLET_OR_RETURN(SWIFTLET_CHECK_TRUE(a))
#define ASSERT_FALSE(a) SWIFTLET_OR_RETURN(SWIFTLET_CHECK_FALSE(a))
#define ASSERT_EQ(a, b) SWIFTLET_OR_RETURN(SWIFTLET_CHECK(Equal, a, b))
#define ASSERT_NE(a, b) SWIFTLET_OR_RETURN(SWIFTLET_CHECK(NotEqual, a, b))
#define ASSERT_LT(a, b) SWIFTLET_OR_RETURN(SWIFTLET_CHECK(Less, a, b))
#define ASSERT_LE(a, b) SWIFTLET_OR_RETURN(SWIFTLET_CHECK(LessEqual, a, b))
#define ASSERT_GT(a, b) SWIFTLET_OR_RETURN(SWIFTLET_CHECK(Greater, a, b))
#define ASSERT_GE(a, b) SWIFTLET_OR_RETURN(SWIFTLET_CHECK(GreaterEqual, a, b))
#define ASSERT_NEAR(a, b, tolerance) SWIFTLET_OR_RETURN(SWIFTLET_CHECK_NEAR(a, b, tolerance))
