// Plans once on the board and prints the answer bit by bit, for compare_plan.py.
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>

#include "board.hpp"
#include "board_config.hpp"
#include "swiftlet/planner.hpp"

namespace {

using swiftlet::Real;

swiftlet::PlannerStorage<swiftlet::kBoard> storage;

void print(std::string_view text) { swiftlet::board::console().write(text); }

/// A space and the 16 hexadecimal digits of the number's bits: printf of a double would bring the heap.
void print_bits(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  std::array<char, 17> text{' '};
  for (std::size_t i = 0; i < 16; ++i) text[i + 1] = "0123456789abcdef"[(bits >> (60 - 4 * i)) & 0xF];
  print({text.data(), text.size()});
}

void print_box(std::string_view name, const swiftlet::Box& box) {
  print(name);
  for (const swiftlet::Vector3& corner : {box.lo, box.hi}) {
    for (const Real coordinate : corner) print_bits(static_cast<double>(coordinate));
  }
  print("\n");
}

void print_segment(const swiftlet::Segment& segment) {
  print("duration");
  print_bits(static_cast<double>(segment.duration));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    print(std::array{"\nx", "\ny", "\nz"}[axis]);
    for (const Real coefficient : segment.coefficients[axis]) print_bits(static_cast<double>(coefficient));
  }
  print("\n");
}

void print_stack() {
  std::array<char, 20> digits{};
  const auto end = std::to_chars(digits.begin(), digits.end(), swiftlet::board::stack_bytes_used());
  print("stack ");
  print({digits.data(), static_cast<std::size_t>(end.ptr - digits.data())});
  print("\n");
}

std::optional<Real> parse_bits(std::string_view digits) {
  std::uint64_t bits = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), bits, 16);
  if (error != std::errc() || digits.size() != 16 || end != digits.data() + digits.size()) return {};
  return static_cast<Real>(std::bit_cast<double>(bits));
}

/// Start, goal, v_max, a_max: eight numbers as their bits.
std::optional<swiftlet::PlanRequest> parse_request(std::span<char* const> words) {
  std::array<Real, 8> numbers{};
  if (words.size() != numbers.size()) return {};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::optional<Real> number = parse_bits(words[i]);
    if (!number) return {};
    numbers[i] = *number;
  }
  swiftlet::PlanRequest request;
  request.start.position = {numbers[0], numbers[1], numbers[2]};
  request.goal.position = {numbers[3], numbers[4], numbers[5]};
  request.v_max = numbers[6];
  request.a_max = numbers[7];
  return request;
}

/// The region without what follows the blob; all of it when its header does not say.
std::span<const std::byte> trim_to_blob(std::span<const std::byte> region) {
  swiftlet::BlobHeader header{};
  if (region.size() < sizeof header) return region;
  std::memcpy(&header, region.data(), sizeof header);
  return region.first(std::min<std::size_t>(region.size(), header.blob_bytes));
}

}  // namespace

/// Usage: plan_image MAP START GOAL V_MAX A_MAX, as `parse_request` wants the numbers.
int main(int argc, char** argv) {
  const std::span<char* const> words(argv, static_cast<std::size_t>(argc));
  if (words.size() < 2) return 2;
  const std::optional<swiftlet::PlanRequest> request = parse_request(words.subspan(2));
  if (!request) return 2;
  const swiftlet::Result<swiftlet::BoxGraphView> graph =
      swiftlet::BoxGraphView::open(trim_to_blob(swiftlet::board::map_region(words[1])));
  if (!graph.ok()) {
    print(swiftlet::describe(graph.status()));
    print("\n");
    return 3;
  }

  swiftlet::Planner planner(storage.spans());
  const swiftlet::Plan& plan = planner.plan(*graph, *request);
  print("status ");
  print(swiftlet::describe(plan.status));
  print("\n");
  for (const swiftlet::Box& box : plan.boxes) print_box("box", box);
  for (const swiftlet::Box& gate : plan.gates) print_box("gate", gate);
  for (const swiftlet::Segment& segment : plan.segments) print_segment(segment);
  print_stack();
  return 0;
}
