#pragma once
#include <vector>

#include "swiftlet/box_graph_view.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet::tools {

/// What a vehicle in a map stands on or comes down to: a pad below its start, else the top of the highest obstacle
/// below it, else a metre below the map, whose edge is free space and no ground.
class Floor {
 public:
  /// The pad is level and kPadSize wide. It lies kPadDrop below the start; higher where an obstacle, or the radius
  /// below the lowest free point under the start, is nearer: a take-off leads straight up into free space.
  Floor(const BoxGraphView& map, std::vector<Box> obstacles, const Vector3& start_W);

  static constexpr double kPadDrop = 1;    // [m]
  static constexpr double kPadSize = 0.5;  // [m]
  static constexpr double kBelowMap = 1;   // [m]

  /// Where the vehicle's centre is when it stands on the pad [m], frame W.
  [[nodiscard]] const Vector3& pad() const { return pad_; }
  /// After a take-off: nothing of it is in the way of a flight that leads down past it.
  void remove_pad() { has_pad_ = false; }
  [[nodiscard]] double below(const Vector3& p_W) const;  ///< [m] height

 private:
  [[nodiscard]] double obstacle_below(const Vector3& p_W) const;

  std::vector<Box> obstacles_;
  double lowest_;
  Vector3 pad_;
  bool has_pad_ = true;
};

}  // namespace swiftlet::tools
