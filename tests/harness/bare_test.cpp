#include "bare_test.hpp"

#include <array>
#include <bit>

#include "board.hpp"
#include "swiftlet/hal/console.hpp"

namespace swiftlet::test {
namespace {

Case* first_case = nullptr;
Case* last_case = nullptr;
int failures_of_case = 0;

void print_name(const Case& test_case) {
  print(test_case.suite());
  print(".");
  print(test_case.name());
}

bool run_case(const Case& test_case) {
  failures_of_case = 0;
  test_case.run();
  if (failures_of_case == 0) return true;
  print("FAILED ");
  print_name(test_case);
  print("\n");
  return false;
}

}  // namespace

Case::Case(std::string_view suite, std::string_view name, void (*body)()) : suite_(suite), name_(name), body_(body) {
  if (last_case == nullptr) {
    first_case = this;
  } else {
    last_case->next_ = this;
  }
  last_case = this;
}

int run_cases() {
  int passed = 0;
  int failed = 0;
  for (const Case* test_case = first_case; test_case != nullptr; test_case = test_case->next()) {
    ++(run_case(*test_case) ? passed : failed);
  }
  print_integer(passed);
  print(" passed, ");
  print_integer(failed);
  print(" failed\n");
  return passed > 0 && failed == 0 ? 0 : 1;
}

void print(std::string_view text) { board::console().write(text); }

void print_integer(std::int64_t value) {
  std::array<char, 20> digits{};
  std::size_t first = digits.size();
  // Negative remainders: the least integer has no positive counterpart.
  for (std::int64_t rest = value; rest != 0 || first == digits.size(); rest /= 10) {
    const auto digit = static_cast<int>(rest % 10);
    digits[--first] = static_cast<char>('0' + (digit < 0 ? -digit : digit));
  }
  if (value < 0) print("-");
  print(std::string_view(digits.data() + first, digits.size() - first));
}

void print_bits(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  std::array<char, 16> digits{};
  for (std::size_t i = 0; i < digits.size(); ++i) digits[i] = "0123456789abcdef"[(bits >> (60 - 4 * i)) & 0xF];
  print(std::string_view(digits.data(), digits.size()));
}

void fail(const char* file, int line, std::string_view claim) {
  ++failures_of_case;
  print(file);
  print(":");
  print_integer(line);
  print(": ");
  print(claim);
  print("\n");
}

}  // namespace swiftlet::test

int main(int /*argc*/, char** /*argv*/) { return swiftlet::test::run_cases(); }
