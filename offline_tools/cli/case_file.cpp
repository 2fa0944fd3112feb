#include "cli/case_file.hpp"

#include <cmath>
#include <limits>
#include <string_view>

#include "cli/failure.hpp"
#include "cli/json_reader.hpp"
#include "map/file_io.hpp"

namespace swiftlet::tools {
namespace {

constexpr const char* kFormat = "swiftlet-case/1";

/// Reads the parts of one case and remembers where it stands, so that every fault names its place.
class CaseReader : private JsonReader {
 public:
  using JsonReader::JsonReader;

  TrajectoryCase read(const Json& json) {
    check_format(json, kFormat);
    if (json.contains("name")) case_.name = word(json["name"], "name");
    case_.boxes = boxes(json, "boxes");
    case_.gates = boxes(json, "gates");
    case_.durations = numbers(member(json, "durations"), "durations");
    case_.start = state(json, "start");
    case_.goal = state(json, "goal");
    case_.v_max = limit(json, "vmax");
    case_.a_max = limit(json, "amax");
    if (json.contains("margins")) {
      const Json& margins = json["margins"];
      case_.margins = {margin(margins, "position"), margin(margins, "velocity"), margin(margins, "acceleration")};
    }
    if (case_.defect.empty()) case_.defect = contradiction();
    return std::move(case_);
  }

 private:
  /// Keeps the first defect.
  void note(const std::string& what) {
    if (case_.defect.empty()) case_.defect = what;
  }

  std::vector<Box> boxes(const Json& json, const std::string& key) {
    std::vector<Box> boxes;
    for (const Json& item : list(member(json, key), key)) {
      std::vector<double> corners = numbers(item, key);
      if (corners.size() != 6) note(key + ": a box has " + std::to_string(corners.size()) + " numbers, not 6");
      corners.resize(6);
      boxes.push_back({{corners[0], corners[1], corners[2]}, {corners[3], corners[4], corners[5]}});
    }
    return boxes;
  }

  Vector3 vector(const Json& json, const std::string& what) {
    std::vector<double> xyz = numbers(json, what);
    if (xyz.size() != 3) note(what + ": " + std::to_string(xyz.size()) + " numbers, not 3");
    xyz.resize(3);
    return {xyz[0], xyz[1], xyz[2]};
  }

  State state(const Json& json, const std::string& key) {
    const Json& item = member(json, key);
    State state;
    state.position = vector(member(item, "position"), key + ".position");
    if (item.contains("velocity")) state.velocity = vector(item["velocity"], key + ".velocity");
    if (item.contains("acceleration")) state.acceleration = vector(item["acceleration"], key + ".acceleration");
    return state;
  }

  double limit(const Json& json, const std::string& key) {
    const Json& item = member(json, key);
    if (item.is_null()) return std::numeric_limits<double>::infinity();
    const double value = number(item, key);
    if (!(value > 0)) note(key + " is not greater than 0");
    return value;
  }

  double margin(const Json& margins, const std::string& key) {
    const double value = number(member(margins, key), key);
    if (!(value >= 0)) note("margins." + key + " is negative");
    return value;
  }

  /// What the numbers say against each other.
  [[nodiscard]] std::string contradiction() const {
    const std::size_t count = case_.boxes.size();
    if (count == 0) return "there is no box";
    if (case_.gates.size() + 1 != count) {
      return std::to_string(count) + " boxes need " + std::to_string(count - 1) + " gates, not " +
             std::to_string(case_.gates.size());
    }
    if (case_.durations.size() != count) {
      return std::to_string(count) + " boxes need as many durations, not " + std::to_string(case_.durations.size());
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (!(case_.durations[i] > 0)) return "duration " + std::to_string(i) + " is not greater than 0";
      if (!is_ordered(case_.boxes[i])) return "box " + std::to_string(i) + " has lo > hi";
    }
    for (std::size_t i = 0; i + 1 < count; ++i) {
      if (!is_ordered(case_.gates[i])) return "gate " + std::to_string(i) + " has lo > hi";
      for (const std::size_t box : {i, i + 1}) {
        if (!holds(case_.boxes[box], case_.gates[i])) {
          return "gate " + std::to_string(i) + " reaches out of box " + std::to_string(box);
        }
      }
    }
    return {};
  }

  static bool is_ordered(const Box& box) { return (box.lo.array() <= box.hi.array()).all(); }
  static bool holds(const Box& outer, const Box& inner) {
    constexpr double kRounding = 1e-6;  // [m] as generate_trajectory: decimals of a file need not agree
    return (inner.lo.array() >= outer.lo.array() - kRounding).all() &&
           (inner.hi.array() <= outer.hi.array() + kRounding).all();
  }

  TrajectoryCase case_;
};

}  // namespace

TrajectoryCase load_case(const std::string& path) { return CaseReader(path).read(load_json(path, kFormat)); }

std::vector<TrajectoryCase> load_cases(const std::string& path) {
  const std::vector<std::byte> bytes = unwrap(read_file(path));
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::vector<TrajectoryCase> cases;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = text.find('\n');
    const std::string_view row = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (row.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    cases.push_back(CaseReader(path + ":" + std::to_string(line)).read(parse_json(path, row, line)));
  }
  if (cases.empty())
    throw Failure{ExitStatus::kBadFile, path + ": holds no case; one swiftlet-case/1 a line is needed"};
  return cases;
}

}  // namespace swiftlet::tools
