#include "swiftlet/mavlink/codec.hpp"

#include <algorithm>
#include <cstring>

#include "dialect.hpp"

namespace swiftlet::mavlink {
namespace {

constexpr std::byte kStart{0xFD};
constexpr std::byte kSignedFlag{0x01};
constexpr std::size_t kHeader = 10;
constexpr std::size_t kChecksum = 2;
constexpr std::size_t kSignature = 13;  // link id 1, time 6, hash 6
constexpr std::size_t kHash = 6;
constexpr std::uint64_t kOldestOfNewStream = 6'000'000;  // one minute

std::uint64_t little_endian(std::span<const std::byte> bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8U | static_cast<std::uint64_t>(bytes[i]);
  return value;
}

void put_little_endian(std::uint64_t value, std::span<std::byte> bytes) {
  for (std::byte& byte : bytes) {
    byte = static_cast<std::byte>(value & 0xFFU);
    value >>= 8U;
  }
}

bool is_signed(std::span<const std::byte> frame) { return (frame[2] & kSignedFlag) != std::byte{0}; }

}  // namespace

void Codec::sign_with(const Signing& signing) {
  signing_ = signing;
  signs_ = true;
  stream_count_ = 0;
}

void Codec::advance_signing_time(std::uint64_t time) { signing_.time = std::max(signing_.time, time); }

std::optional<Frame> Codec::receive(std::span<const std::byte>& bytes) {
  discard(given_out_bytes_);
  given_out_bytes_ = 0;
  while (true) {
    const std::size_t wanted = wanted_bytes();
    if (wanted == 0) {  // no frame starts here
      discard(1);
      ++counters_.skipped_bytes;
      continue;
    }
    const std::size_t missing = wanted - std::min(wanted, received_bytes_);
    const std::size_t taken = std::min(missing, bytes.size());
    std::copy_n(bytes.begin(), taken, received_.begin() + static_cast<std::ptrdiff_t>(received_bytes_));
    received_bytes_ += taken;
    bytes = bytes.subspan(taken);
    if (taken < missing) return std::nullopt;
    if (missing > 0) continue;  // the new bytes may want more

    Frame frame;
    const Verdict verdict = judge(wanted, frame);
    if (verdict == Verdict::kDamaged) {
      discard(1);
      ++counters_.skipped_bytes;
    } else if (verdict == Verdict::kSkip) {
      discard(wanted);
    } else {
      ++counters_.frames;
      given_out_bytes_ = wanted;
      return frame;
    }
  }
}

/// Bytes of the frame that starts at the front, as far as can be told; 0 when none can start there.
std::size_t Codec::wanted_bytes() const {
  if (received_bytes_ == 0) return 1;
  if (received_[0] != kStart) return 0;
  if (received_bytes_ < 3) return 3;
  if ((received_[2] & ~kSignedFlag) != std::byte{0}) return 0;  // a flag that we do not know: not to be understood
  return kHeader + static_cast<std::size_t>(received_[1]) + kChecksum + (is_signed(received_) ? kSignature : 0);
}

void Codec::discard(std::size_t count) {
  std::copy(received_.begin() + static_cast<std::ptrdiff_t>(count),
            received_.begin() + static_cast<std::ptrdiff_t>(received_bytes_), received_.begin());
  received_bytes_ -= count;
}

Codec::Verdict Codec::judge(std::size_t frame_bytes, Frame& frame) {
  const std::span<const std::byte> bytes(received_.data(), frame_bytes);
  const auto payload_bytes = static_cast<std::size_t>(bytes[1]);
  frame.sequence = static_cast<std::uint8_t>(bytes[4]);
  frame.from = {static_cast<std::uint8_t>(bytes[5]), static_cast<std::uint8_t>(bytes[6])};
  frame.id = static_cast<std::uint32_t>(little_endian(bytes.subspan(7, 3)));
  frame.payload = bytes.subspan(kHeader, payload_bytes);
  const std::optional<std::uint8_t> layout = layout_byte(frame.id);
  if (!layout.has_value()) {
    ++counters_.unknown;
    return Verdict::kDamaged;  // its length may be wrong as well
  }
  const std::size_t checked = kHeader + payload_bytes;
  if (little_endian(bytes.subspan(checked, kChecksum)) != frame_checksum(bytes.subspan(1, checked - 1), *layout)) {
    ++counters_.bad_checksum;
    return Verdict::kDamaged;
  }
  return signs_ && is_signed(bytes) ? judge_signature(frame_bytes, frame) : Verdict::kGood;
}

Codec::Verdict Codec::judge_signature(std::size_t frame_bytes, Frame& frame) {
  const std::span<const std::byte> bytes(received_.data(), frame_bytes);
  const std::span<const std::byte> hash = bytes.last(kHash);
  const auto expected = signature_of(signing_.key, bytes.first(frame_bytes - kHash));
  if (!std::equal(hash.begin(), hash.end(), expected.begin())) {
    ++counters_.bad_signature;
    return Verdict::kSkip;
  }
  const std::span<const std::byte> signature = bytes.last(kSignature);
  const std::uint64_t time = little_endian(signature.subspan(1, 6));
  if (!is_newest(frame.from, static_cast<std::uint8_t>(signature[0]), time)) {
    ++counters_.replayed;
    return Verdict::kSkip;
  }
  advance_signing_time(time);
  frame.authentic = true;
  return Verdict::kGood;
}

/// Remembers `time` when it is newer than all of the same sender and link; a new stream may be a minute behind us.
bool Codec::is_newest(Address from, std::uint8_t link_id, std::uint64_t time) {
  for (std::size_t i = 0; i < stream_count_; ++i) {
    Stream& stream = streams_[i];
    if (stream.from != from || stream.link_id != link_id) continue;
    if (time <= stream.newest) return false;
    stream.newest = time;
    return true;
  }
  if (stream_count_ == kMaxStreams || time + kOldestOfNewStream < signing_.time) return false;
  streams_[stream_count_++] = {from, link_id, time};
  return true;
}

std::span<const std::byte> Codec::seal(std::uint32_t id, std::size_t payload_bytes) {
  const std::span<std::byte> bytes(sent_);
  bytes[0] = kStart;
  bytes[1] = static_cast<std::byte>(payload_bytes);
  bytes[2] = signs_ ? kSignedFlag : std::byte{0};
  bytes[3] = std::byte{0};
  bytes[4] = static_cast<std::byte>(sequence_++);
  bytes[5] = static_cast<std::byte>(self_.system);
  bytes[6] = static_cast<std::byte>(self_.component);
  put_little_endian(id, bytes.subspan(7, 3));
  const std::size_t checked = kHeader + payload_bytes;
  const std::optional<std::uint8_t> layout = layout_byte(id);
  put_little_endian(frame_checksum(bytes.subspan(1, checked - 1), layout.value_or(0)), bytes.subspan(checked, 2));
  const std::size_t unsigned_bytes = checked + kChecksum;
  if (!signs_) return bytes.first(unsigned_bytes);

  const std::span<std::byte> signature = bytes.subspan(unsigned_bytes, kSignature);
  ++signing_.time;  // never the same twice
  signature[0] = static_cast<std::byte>(signing_.link_id);
  put_little_endian(signing_.time, signature.subspan(1, 6));
  const auto hash = signature_of(signing_.key, bytes.first(unsigned_bytes + kSignature - kHash));
  std::copy(hash.begin(), hash.end(), signature.last(kHash).begin());
  return bytes.first(unsigned_bytes + kSignature);
}

template <typename Message>
std::span<const std::byte> Codec::encode(const Message& message) {
  return seal(Message::kId, pack(message, std::span(sent_).subspan(kHeader, kMaxPayload)));
}

#define SWIFTLET_ENCODE(Message) template std::span<const std::byte> Codec::encode(const Message& message)
SWIFTLET_ENCODE(Heartbeat);
SWIFTLET_ENCODE(SystemStatus);
SWIFTLET_ENCODE(ParameterRequest);
SWIFTLET_ENCODE(ParameterListRequest);
SWIFTLET_ENCODE(ParameterValue);
SWIFTLET_ENCODE(ParameterSet);
SWIFTLET_ENCODE(AttitudeQuaternion);
SWIFTLET_ENCODE(LocalPositionNed);
SWIFTLET_ENCODE(CommandInt);
SWIFTLET_ENCODE(CommandLong);
SWIFTLET_ENCODE(CommandAck);
SWIFTLET_ENCODE(SetAttitudeTarget);
SWIFTLET_ENCODE(SetPositionTarget);
SWIFTLET_ENCODE(PositionTarget);
SWIFTLET_ENCODE(TimeSyncMessage);
SWIFTLET_ENCODE(ExtendedSystemState);
SWIFTLET_ENCODE(StatusText);
SWIFTLET_ENCODE(Odometry);
SWIFTLET_ENCODE(CurrentMode);
#undef SWIFTLET_ENCODE

}  // namespace swiftlet::mavlink
