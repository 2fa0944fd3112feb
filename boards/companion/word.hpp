#pragma once
#include <cstdint>
#include <optional>

#include "swiftlet/types.hpp"

namespace swiftlet::companion {

/// One word of the operator, however it came: by console, or by a program that owns the companion.
struct Word {
  enum class Kind : std::uint8_t {
    kAddGoal,  ///< `a`, `yaw`
    kSetGoal,  ///< `a`, `yaw`
    kEngage,
    kRelease,
    kStop,
    kLand,
    kBlock,    ///< `id`, the box from `a` to `b`
    kUnblock,  ///< `id`
    kLimits,   ///< speed a.x, acceleration a.y
  };
  Kind kind = Kind::kStop;
  std::uint32_t id = 0;
  Vector3 a = Vector3::Zero();
  Vector3 b = Vector3::Zero();
  std::optional<Real> yaw{};
};

}  // namespace swiftlet::companion
