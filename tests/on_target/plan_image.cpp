// Answers requests on the board and prints the answers bit by bit, for compare_plan.py.
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <span>
#include <string_view>

#include "board.hpp"
#include "board_config.hpp"
#include "map_blob.hpp"
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

void print_count(std::string_view name, std::uint64_t count) {
  std::array<char, 20> digits{};
  const auto end = std::to_chars(digits.begin(), digits.end(), count);
  print(name);
  print({digits.data(), static_cast<std::size_t>(end.ptr - digits.data())});
}

void print_plan(const swiftlet::Plan& plan) {
  print("status ");
  print(swiftlet::describe(plan.status));
  print("\n");
  for (const swiftlet::Box& box : plan.boxes) print_box("box", box);
  for (const swiftlet::Box& gate : plan.gates) print_box("gate", gate);
  for (const swiftlet::Segment& segment : plan.segments) print_segment(segment);
}

/// Plans, and prints the answer with what each stage took: the search stage is all of find_corridor (checks, location,
/// A*, corridor, taut path), the trajectory stage all of fit_trajectory (durations, QP, refinement, certificate).
void answer(swiftlet::Planner& planner, const swiftlet::BoxGraphView& graph, const swiftlet::PlanRequest& request) {
  const std::uint64_t begin = swiftlet::board::instructions_executed();
  const bool found = planner.find_corridor(graph, request) == swiftlet::Status::kOk;
  const std::uint64_t searched = swiftlet::board::instructions_executed();
  if (found) (void)planner.fit_trajectory(request);
  const std::uint64_t fitted = swiftlet::board::instructions_executed();
  print_plan(planner.result());
  print_count("counts ", planner.result().search.reached);
  print_count(" ", planner.result().search.expanded);
  print_count(" ", searched - begin);
  print_count(" ", fitted - searched);
  print("\n");
}

/// Start, goal, v_max, a_max, as compare_plan.py writes them behind the blob.
using Row = std::array<double, 8>;

swiftlet::PlanRequest read_request(std::span<const std::byte> bytes) {
  Row row{};
  std::memcpy(row.data(), bytes.data(), sizeof row);
  swiftlet::PlanRequest request;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto index = static_cast<Eigen::Index>(axis);
    request.start.position[index] = static_cast<Real>(row[axis]);
    request.goal.position[index] = static_cast<Real>(row[3 + axis]);
  }
  request.v_max = static_cast<Real>(row[6]);
  request.a_max = static_cast<Real>(row[7]);
  return request;
}

}  // namespace

/// Usage: plan_image MAP: a blob, then the number of requests as a double and their rows.
int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::span<const std::byte> region = swiftlet::board::map_region(argv[1]);
  const std::span<const std::byte> blob = swiftlet::board::trim_to_blob(region);
  const swiftlet::Result<swiftlet::BoxGraphView> graph = swiftlet::BoxGraphView::open(blob);
  if (!graph.ok()) {
    print(swiftlet::describe(graph.status()));
    print("\n");
    return 3;
  }

  std::span<const std::byte> rest = region.subspan(blob.size());
  double count = 0;
  if (rest.size() < sizeof count) return 2;
  std::memcpy(&count, rest.data(), sizeof count);
  rest = rest.subspan(sizeof count);
  if (!(count >= 1 && count * sizeof(Row) <= static_cast<double>(rest.size()))) return 2;
  static swiftlet::Planner planner(storage.spans());  // outlives every plan, as on a vehicle: no part of a plan's stack
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    answer(planner, *graph, read_request(rest.subspan(i * sizeof(Row))));
  }
  print_count("stack ", swiftlet::board::stack_bytes_used());
  print("\n");
  return 0;
}
