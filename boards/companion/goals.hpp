#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "companion/storage.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet::companion {

/// A place to fly to, in W.
struct Goal {
  std::uint32_t id = 0;                ///< counts goals
  Vector3 position = Vector3::Zero();  ///< [m]
  std::optional<Real> yaw{};           ///< [rad] to be held there
};

/// The goals to be flown to, first come, first served.
class Goals {
 public:
  /// The new goal's id; 0 when there is no room.
  std::uint32_t add(const Vector3& position, std::optional<Real> yaw) {
    if (size_ == kMostGoals) return 0;
    goals_[(first_ + size_++) % kMostGoals] = {++last_id_, position, yaw};
    return last_id_;
  }
  /// There must be one.
  void drop_first() {
    first_ = (first_ + 1) % kMostGoals;
    --size_;
  }
  void clear() { size_ = 0; }

  /// Ids ascend from the first to the last.
  [[nodiscard]] bool contains(std::uint32_t id) const { return size_ > 0 && goals_[first_].id <= id && id <= last_id_; }
  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(size_); }
  [[nodiscard]] const Goal* first() const { return size_ > 0 ? &goals_[first_] : nullptr; }

 private:
  std::array<Goal, kMostGoals> goals_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  std::uint32_t last_id_ = 0;
};

}  // namespace swiftlet::companion
