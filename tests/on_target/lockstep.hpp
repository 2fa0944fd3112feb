#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "swiftlet/hal/storage.hpp"
#include "swiftlet/hal/uart.hpp"
#include "swiftlet/mavlink/messages.hpp"

/// Lock-step of companion_image and companion_peer, by TIMESYNC: before each step the image asks for the time. The peer
/// lets the vehicle fly on for a period, sends what came of it, and answers.
namespace swiftlet::lockstep {

// Addresses of nobody who flies: the link takes no notice of them, and the autopilot gets nothing of it.
inline constexpr mavlink::Address kImage{1, 25};  ///< MAV_COMP_ID_USER1
inline constexpr mavlink::Address kPeer{255, 25};

inline constexpr std::int64_t kTheEnd = -1;  ///< [ns] an answer below 0: the flight is over

// The image's end of the line, and where its log goes: bare_line.cpp, hosted_line.cpp.

hal::Uart& line();

/// What the line brings, waiting until there is something; 0 when nothing can come any more.
std::size_t wait_for_bytes(std::span<std::byte> into);

hal::Storage& storage();

/// Makes a file of the storage one of the working folder of who runs the image; it did not exist. False when it cannot.
bool hand_out(std::string_view name);

}  // namespace swiftlet::lockstep
