#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "swiftlet/mavlink/messages.hpp"

/// What the generated headers know, without them.
namespace swiftlet::mavlink {

/// The byte by which a message's checksum depends on its layout; nothing for a message that the dialect does not have.
std::optional<std::uint8_t> layout_byte(std::uint32_t id);

/// Checksum of a frame (CRC-16/MCRF4XX): `bytes` without the start byte, then the layout byte.
std::uint16_t frame_checksum(std::span<const std::byte> bytes, std::uint8_t layout);

/// First six bytes of SHA-256 over `key`, then `bytes`: a signature when `bytes` is a frame up to the signature's time.
std::array<std::byte, 6> signature_of(std::span<const std::byte> key, std::span<const std::byte> bytes);

/// A message's payload, trailing zeros left out, at the front of `payload`, which holds kMaxPayload bytes; its size.
template <typename Message>
std::size_t pack(const Message& message, std::span<std::byte> payload);

}  // namespace swiftlet::mavlink
