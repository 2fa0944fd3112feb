#pragma once
#include <cstdint>

#include "swiftlet/mavlink/messages.hpp"
#include "swiftlet/types.hpp"

/// What companion_image and companion_peer agree on.
namespace swiftlet::classroom {

inline const Vector3 kStart{Real(0.48), Real(0.48), 0};  ///< [m] frame W
inline constexpr Real kStartYaw = Real(0.4);             ///< [rad] from east

// Lock-step by TIMESYNC: after each step the image asks for the time. The peer lets the vehicle fly on for a period,
// sends what came of it, and answers. These are addresses of nobody who flies: both ends of the link ignore them.
inline constexpr mavlink::Address kImage{1, 25};   ///< MAV_COMP_ID_USER1
inline constexpr mavlink::Address kPeer{255, 25};  ///< an answer with a time below 0 ends the flight
inline constexpr std::int64_t kTheEnd = -1;

}  // namespace swiftlet::classroom
