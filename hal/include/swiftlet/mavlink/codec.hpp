#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "swiftlet/mavlink/messages.hpp"

/// MAVLink 2 frames: bytes to messages and back. Serves either end of a link; knows neither time nor devices, and uses
/// no heap.
namespace swiftlet::mavlink {

inline constexpr std::size_t kMaxPayload = 255;
inline constexpr std::size_t kMaxFrame = 280;  ///< header 10, payload 255, checksum 2, signature 13

/// A frame whose checksum is right. `payload` lives until the next call of `Codec::receive`.
struct Frame {
  std::uint32_t id = 0;
  Address from;
  std::uint8_t sequence = 0;
  bool authentic = false;  ///< Signed with our key, and newer than all that came before it on its link.
  std::span<const std::byte> payload;
};

/// The message in a frame; nothing when it is of another kind. Bytes that a sender left out are zero (MAVLink 2
/// truncates), and bytes of extensions that we do not know are ignored. Values are not checked.
template <typename Message>
std::optional<Message> decode(const Frame& frame);

/// Message signing. Times are counted in 10 us since the start of 2015 (UTC).
struct Signing {
  std::array<std::byte, 32> key{};
  std::uint8_t link_id = 0;
  /// Never let it fall below what was used before with this key: keep it in storage where there is no time of day.
  std::uint64_t time = 0;
};

/// What became of the bytes received. Nothing is lost without being counted.
struct CodecCounters {
  std::uint32_t frames = 0;         ///< Given out.
  std::uint32_t skipped_bytes = 0;  ///< In no frame that could be checked.
  std::uint32_t bad_checksum = 0;   ///< Candidates for a frame that were none, or damaged.
  std::uint32_t unknown = 0;        ///< Candidates of a message that the dialect does not have: not to be checked.
  std::uint32_t bad_signature = 0;  ///< Signed with another key.
  std::uint32_t replayed = 0;       ///< Signed with our key, not newer than what came before it.
};

class Codec {
 public:
  explicit Codec(Address self) : self_(self) {}
  [[nodiscard]] Address self() const { return self_; }

  /// From now on frames are signed, and frames with a wrong signature or an old one are dropped. Unsigned frames are
  /// still given out, as not `authentic`: what to do with them is for the receiver to say.
  void sign_with(const Signing& signing);
  [[nodiscard]] bool signs() const { return signs_; }
  /// Moves the signing time forward to `time`; never back.
  void advance_signing_time(std::uint64_t time);
  [[nodiscard]] std::uint64_t signing_time() const { return signing_.time; }

  /// Takes bytes off the front of `bytes` until a frame is complete; nothing when all were taken and none is. Bytes
  /// of a frame that is damaged or unknown are looked through again for the frames that it may have swallowed.
  std::optional<Frame> receive(std::span<const std::byte>& bytes);
  [[nodiscard]] const CodecCounters& counters() const { return counters_; }

  /// The message as a frame of ours; the bytes live until the next call.
  template <typename Message>
  std::span<const std::byte> encode(const Message& message);

 private:
  enum class Verdict : std::uint8_t { kGood, kDamaged, kSkip };
  struct Stream {  // of signed frames
    Address from;
    std::uint8_t link_id = 0;
    std::uint64_t newest = 0;
  };
  static constexpr std::size_t kMaxStreams = 16;

  [[nodiscard]] std::size_t wanted_bytes() const;
  void discard(std::size_t count);
  Verdict judge(std::size_t frame_bytes, Frame& frame);
  Verdict judge_signature(std::size_t frame_bytes, Frame& frame);
  bool is_newest(Address from, std::uint8_t link_id, std::uint64_t time);
  std::span<const std::byte> seal(std::uint32_t id, std::size_t payload_bytes);

  Address self_;
  bool signs_ = false;
  std::uint8_t sequence_ = 0;
  Signing signing_;
  std::array<Stream, kMaxStreams> streams_{};
  std::size_t stream_count_ = 0;
  CodecCounters counters_;
  std::array<std::byte, kMaxFrame> received_{};
  std::size_t received_bytes_ = 0;
  std::size_t given_out_bytes_ = 0;  // of the frame in front, to be discarded at the next call
  std::array<std::byte, kMaxFrame> sent_{};
};

}  // namespace swiftlet::mavlink
