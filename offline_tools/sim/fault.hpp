#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace swiftlet::tools {

/// What can go wrong in a simulated flight.
enum class FaultKind : std::uint8_t {
  kCut,
  kCorrupt,
  kLoss,
  kStall,
  kStarve,
  kOdometryStale,
  kOdometryNan,
  kPositionJump,
  kRestart,
  kPilot,
  kClockJump,
};

struct Fault {
  FaultKind kind;
  double at;        ///< [s] from the start of the simulation
  double duration;  ///< [s]; infinite: for good
};

/// "KIND@T" or "KIND@T+D", with D the duration where the kind has one; nothing when it is neither.
std::optional<Fault> parse_fault(std::string_view text);

const char* describe(FaultKind kind);  ///< its name in `parse_fault`

/// A line for each kind: name, meaning and usual duration.
std::string list_faults();

}  // namespace swiftlet::tools
