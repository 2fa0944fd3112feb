#include "companion/telemetry.hpp"

namespace swiftlet::companion {

const char* describe(Phase phase) {
  switch (phase) {
    case Phase::kGround:
      return "ground";
    case Phase::kTakeoff:
      return "take-off";
    case Phase::kMission:
      return "mission";
    case Phase::kLanding:
      return "landing";
    case Phase::kDone:
      return "done";
  }
  return "unknown phase";
}

}  // namespace swiftlet::companion
