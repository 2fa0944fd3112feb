#include "sim/fault.hpp"

#include <array>
#include <charconv>
#include <cmath>

namespace swiftlet::tools {
namespace {

constexpr double kForGood = std::numeric_limits<double>::infinity();
constexpr double kAtOnce = 0;

struct KindText {
  FaultKind kind;
  const char* name;
  double duration;  ///< [s] usual one
  const char* meaning;
};

constexpr std::array kKinds{
    KindText{FaultKind::kCut, "cut", kForGood, "the link ends in both directions, after any byte"},
    KindText{FaultKind::kCorrupt, "corrupt", 5, "1 % of the bytes change, in both directions"},
    KindText{FaultKind::kLoss, "loss", 5, "30 % of the messages are lost, in both directions"},
    KindText{FaultKind::kStall, "stall", 0.2, "the link holds everything back, then delivers it at once"},
    KindText{FaultKind::kStarve, "starve", 2, "set-points are lost on their way to the autopilot"},
    KindText{FaultKind::kOdometryStale, "odometry-stale", 2, "position and attitude repeat with their old times"},
    KindText{FaultKind::kOdometryNan, "odometry-nan", 1, "position and attitude are not numbers"},
    KindText{FaultKind::kPositionJump, "position-jump", kAtOnce, "the estimate jumps by 1 m and stays there"},
    KindText{FaultKind::kRestart, "restart", 3, "the autopilot reboots: motors off, silent, then disarmed"},
    KindText{FaultKind::kPilot, "pilot", kForGood, "the pilot flies in POSCTL, and gives back after a duration"},
    KindText{FaultKind::kClockJump, "clock-jump", kAtOnce, "the autopilot's clock jumps 5 s ahead and stays there"},
};

std::optional<double> seconds(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool usable = error == std::errc() && end == text.data() + text.size() && std::isfinite(value) && value >= 0;
  return usable ? std::optional(value) : std::nullopt;
}

}  // namespace

std::optional<Fault> parse_fault(std::string_view text) {
  const std::size_t at_sign = text.find('@');
  if (at_sign == std::string_view::npos) return std::nullopt;
  for (const KindText& kind : kKinds) {
    if (text.substr(0, at_sign) != kind.name) continue;
    const std::string_view times = text.substr(at_sign + 1);
    const std::size_t plus = times.find('+');
    const std::optional<double> at = seconds(times.substr(0, plus));
    if (!at) return std::nullopt;
    if (plus == std::string_view::npos) return Fault{kind.kind, *at, kind.duration};
    const std::optional<double> duration = seconds(times.substr(plus + 1));
    if (!duration || kind.duration == kAtOnce) return std::nullopt;
    return Fault{kind.kind, *at, *duration};
  }
  return std::nullopt;
}

const char* describe(FaultKind kind) { return kKinds[static_cast<std::size_t>(kind)].name; }

std::string list_faults() {
  std::string text;
  for (const KindText& kind : kKinds) {
    std::string line = std::string("  ") + kind.name + "@T";
    const bool lasts = kind.duration != kAtOnce;
    if (lasts) line += "[+D]";
    line.resize(24, ' ');
    line += kind.meaning;
    if (lasts && std::isfinite(kind.duration)) {
      std::array<char, 16> digits{};
      const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), kind.duration).ptr;
      line += " (" + std::string(digits.data(), end) + " s)";
    }
    text += line + '\n';
  }
  return text;
}

}  // namespace swiftlet::tools
