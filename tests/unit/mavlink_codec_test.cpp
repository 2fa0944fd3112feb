#include <algorithm>
#include <array>

#include "swiftlet/mavlink/codec.hpp"
#include "swiftlet_test.hpp"

namespace {

using swiftlet::mavlink::Address;
using swiftlet::mavlink::Codec;
using swiftlet::mavlink::Frame;
using swiftlet::mavlink::Heartbeat;
using swiftlet::mavlink::LocalPositionNed;
using swiftlet::mavlink::SetPositionTarget;
using swiftlet::mavlink::Signing;
using swiftlet::mavlink::SystemState;

constexpr Address kCompanion{1, 195};

// Frames made with pymavlink 2.4.50: HEARTBEAT of an active onboard controller, the same signed with key 0..31, link 3,
// time 0x0123456789AB, and a set-point with sequence 7.
constexpr std::array<std::uint8_t, 21> kHeartbeatBytes{0xFD, 0x09, 0x00, 0x00, 0x00, 0x01, 0xC3, 0x00, 0x00, 0x00, 0x00,
                                                       0x00, 0x00, 0x00, 0x12, 0x08, 0x00, 0x04, 0x03, 0x73, 0xEA};
constexpr std::array<std::uint8_t, 34> kSignedHeartbeatBytes{
    0xFD, 0x09, 0x01, 0x00, 0x00, 0x01, 0xC3, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x12, 0x08, 0x00,
    0x04, 0x03, 0x94, 0x12, 0x03, 0xAB, 0x89, 0x67, 0x45, 0x23, 0x01, 0x14, 0x62, 0x56, 0x5D, 0xB5, 0x2E};
constexpr std::array<std::uint8_t, 65> kSetPointBytes{
    0xFD, 0x35, 0x00, 0x00, 0x07, 0x01, 0xC3, 0x54, 0x00, 0x00, 0xE8, 0x03, 0x00, 0x00, 0x00, 0x00, 0x80,
    0x3F, 0x00, 0x00, 0x00, 0x40, 0x00, 0x00, 0x40, 0xC0, 0x00, 0x00, 0x00, 0x3F, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x80, 0xBE, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0xC0, 0x3F, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x01, 0x01, 0xE1, 0x80};

Heartbeat companion_heartbeat() {
  Heartbeat heartbeat;
  heartbeat.type = swiftlet::mavlink::kTypeOnboardController;
  heartbeat.autopilot = swiftlet::mavlink::kAutopilotInvalid;
  heartbeat.system_status = SystemState::kActive;
  return heartbeat;
}

template <std::size_t kSize>
bool equal(std::span<const std::byte> bytes, const std::array<std::uint8_t, kSize>& expected) {
  return std::ranges::equal(bytes, std::as_bytes(std::span(expected)));
}

/// How many frames `codec` finds in `bytes`.
int count_frames(Codec& codec, std::span<const std::byte> bytes) {
  int count = 0;
  while (codec.receive(bytes).has_value()) ++count;
  return count;
}

Signing test_signing(std::uint8_t link_id, std::uint64_t time) {
  Signing signing;
  for (std::size_t i = 0; i < signing.key.size(); ++i) signing.key[i] = static_cast<std::byte>(i);
  signing.link_id = link_id;
  signing.time = time;
  return signing;
}

TEST(MavlinkCodec, WritesTheSameBytesAsAnotherImplementation) {
  Codec codec(kCompanion);
  EXPECT_TRUE(equal(codec.encode(companion_heartbeat()), kHeartbeatBytes));
  for (int i = 1; i < 7; ++i) static_cast<void>(codec.encode(companion_heartbeat()));
  SetPositionTarget target;
  target.time_boot_ms = 1000;
  target.target = {1, 1};
  target.position.value = {1, 2, -3};
  target.velocity.value = {swiftlet::Real(0.5), 0, swiftlet::Real(-0.25)};
  target.yaw = 1.5F;
  EXPECT_TRUE(equal(codec.encode(target), kSetPointBytes));
}

TEST(MavlinkCodec, ReadsTheBytesOfAnotherImplementation) {
  Codec codec({1, 1});
  std::span<const std::byte> bytes = std::as_bytes(std::span(kSetPointBytes));
  const auto frame = codec.receive(bytes);
  ASSERT_TRUE(frame.has_value());
  EXPECT_TRUE(frame->from == kCompanion);
  EXPECT_EQ(frame->sequence, 7);
  EXPECT_FALSE(frame->authentic);
  EXPECT_FALSE(decode<Heartbeat>(*frame).has_value());
  const auto target = decode<SetPositionTarget>(*frame);
  ASSERT_TRUE(target.has_value());
  EXPECT_EQ(target->time_boot_ms, 1000);
  EXPECT_NEAR(target->position.value.z(), -3, 0);
  EXPECT_NEAR(target->velocity.value.z(), -0.25, 0);
  EXPECT_NEAR(target->yaw, 1.5, 0);
  EXPECT_FALSE(codec.receive(bytes).has_value());
  EXPECT_EQ(codec.counters().frames, 1);
  EXPECT_EQ(codec.counters().skipped_bytes, 0);
}

TEST(MavlinkCodec, TakesAFrameByteByByteAndAfterHalfAFrame) {
  Codec codec({1, 1});
  const auto whole = std::as_bytes(std::span(kHeartbeatBytes));
  int frames = count_frames(codec, whole.subspan(9));  // joined mid-packet
  for (const std::byte& byte : whole) frames += count_frames(codec, std::span(&byte, 1));
  EXPECT_EQ(frames, 1);
}

TEST(MavlinkCodec, CountsWhatItCannotCheck) {
  Codec codec({1, 1});
  std::array<std::byte, 21> bytes{};
  std::ranges::copy(std::as_bytes(std::span(kHeartbeatBytes)), bytes.begin());
  bytes[8] = std::byte{0xEA};  // message 59904
  EXPECT_EQ(count_frames(codec, bytes), 0);
  EXPECT_EQ(codec.counters().unknown, 1);
  EXPECT_EQ(codec.counters().bad_checksum, 0);
  EXPECT_EQ(count_frames(codec, std::as_bytes(std::span(kHeartbeatBytes))), 1);
}

TEST(MavlinkCodec, RefusesFlagsThatItDoesNotKnow) {
  Codec codec({1, 1});
  std::array<std::byte, 21> bytes{};
  std::ranges::copy(std::as_bytes(std::span(kHeartbeatBytes)), bytes.begin());
  bytes[2] = std::byte{0x02};
  EXPECT_EQ(count_frames(codec, bytes), 0);
  EXPECT_EQ(codec.counters().skipped_bytes, 21);
}

/// A stream of mixed messages with 1 % of its bytes damaged: every frame without a damaged byte arrives.
TEST(MavlinkCodec, LosesOnlyTheFramesThatAreDamaged) {
  Codec sender({1, 1});
  Codec receiver(kCompanion);
  std::uint32_t random = 12345;
  const auto next = [&random] { return random = random * 1664525U + 1013904223U, random >> 8U; };
  int whole = 0;
  int received = 0;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    LocalPositionNed position;
    position.time_boot_ms = i * 20;
    position.position.value = {swiftlet::Real(i), 2, swiftlet::Real(-1.5)};
    const auto frame = i % 3 == 0 ? sender.encode(companion_heartbeat()) : sender.encode(position);
    std::array<std::byte, swiftlet::mavlink::kMaxFrame> bytes{};
    std::ranges::copy(frame, bytes.begin());
    bool damaged = false;
    for (std::size_t k = 0; k < frame.size(); ++k) {
      if (next() % 100 != 0) continue;
      bytes[k] ^= static_cast<std::byte>(1U + next() % 255U);
      damaged = true;
    }
    whole += damaged ? 0 : 1;
    received += count_frames(receiver, std::span(bytes).first(frame.size()));
  }
  EXPECT_GT(whole, 1200);
  EXPECT_LT(whole, 1700);
  EXPECT_LE(received, whole);
  EXPECT_GE(received, whole - 6);  // those that still wait behind a candidate when the stream ends
}

TEST(MavlinkSigning, WritesAndChecksTheSignatureOfAnotherImplementation) {
  Codec sender(kCompanion);
  sender.sign_with(test_signing(3, 0x0123456789AA));
  EXPECT_TRUE(equal(sender.encode(companion_heartbeat()), kSignedHeartbeatBytes));
  Codec receiver({1, 1});
  receiver.sign_with(test_signing(0, 0x0123456789AB));
  std::span<const std::byte> bytes = std::as_bytes(std::span(kSignedHeartbeatBytes));
  const auto frame = receiver.receive(bytes);
  ASSERT_TRUE(frame.has_value());
  EXPECT_TRUE(frame->authentic);
}

TEST(MavlinkSigning, RefusesAnotherKeyAReplayAndAnOldStream) {
  Codec receiver({1, 1});
  receiver.sign_with(test_signing(0, 0x0123456789AB));
  const auto bytes = std::as_bytes(std::span(kSignedHeartbeatBytes));
  EXPECT_EQ(count_frames(receiver, bytes), 1);
  EXPECT_EQ(count_frames(receiver, bytes), 0);
  EXPECT_EQ(receiver.counters().replayed, 1);

  Codec other_key(kCompanion);
  Signing signing = test_signing(3, 0x0223456789AB);
  signing.key[31] = std::byte{0};
  other_key.sign_with(signing);
  EXPECT_EQ(count_frames(receiver, other_key.encode(companion_heartbeat())), 0);
  EXPECT_EQ(receiver.counters().bad_signature, 1);

  Codec a_minute_late({1, 200});
  a_minute_late.sign_with(test_signing(0, 0x0123456789AB - 6'000'002));
  EXPECT_EQ(count_frames(receiver, a_minute_late.encode(companion_heartbeat())), 0);
  EXPECT_EQ(receiver.counters().replayed, 2);
  Codec just_in_time({1, 201});
  just_in_time.sign_with(test_signing(0, 0x0123456789AB - 6'000'000));
  EXPECT_EQ(count_frames(receiver, just_in_time.encode(companion_heartbeat())), 1);
}

TEST(MavlinkSigning, MarksUnsignedFramesAndIgnoresSignaturesWithoutAKey) {
  Codec with_key({1, 1});
  with_key.sign_with(test_signing(0, 0));
  std::span<const std::byte> bytes = std::as_bytes(std::span(kHeartbeatBytes));
  auto frame = with_key.receive(bytes);
  ASSERT_TRUE(frame.has_value());
  EXPECT_FALSE(frame->authentic);
  Codec without_key({1, 1});
  bytes = std::as_bytes(std::span(kSignedHeartbeatBytes));
  frame = without_key.receive(bytes);
  ASSERT_TRUE(frame.has_value());
  EXPECT_FALSE(frame->authentic);
}

TEST(MavlinkSigning, FollowsTheNewestTimeHeard) {
  Codec codec({1, 1});
  codec.sign_with(test_signing(0, 0x0123456789AB - 100));
  EXPECT_EQ(count_frames(codec, std::as_bytes(std::span(kSignedHeartbeatBytes))), 1);
  EXPECT_EQ(codec.signing_time(), 0x0123456789AB);
  codec.advance_signing_time(5);
  EXPECT_EQ(codec.signing_time(), 0x0123456789AB);
}

}  // namespace
