#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "dialect.hpp"
#include "swiftlet/hal/uart.hpp"
#include "swiftlet/mavlink/link.hpp"

namespace {

using namespace swiftlet::mavlink;  // NOLINT(google-build-using-namespace): every name below is from there

void require(bool promise) {
  if (!promise) std::abort();
}

/// What the link reads is the input; what it writes must be whole frames of ours.
class FuzzUart final : public swiftlet::hal::Uart {
 public:
  std::size_t write(std::span<const std::byte> bytes) override {
    const std::size_t taken = bytes.size();
    int frames = 0;
    while (reader_.receive(bytes).has_value()) ++frames;
    require(frames == 1 && reader_.counters().skipped_bytes == 0);
    return taken;
  }
  std::size_t read(std::span<std::byte> into) override {
    const std::size_t count = std::min(into.size(), waiting_.size());
    std::copy_n(waiting_.begin(), count, into.begin());
    waiting_ = waiting_.subspan(count);
    return count;
  }
  [[nodiscard]] std::uint32_t overruns() const override { return 0; }
  void receive(std::span<const std::byte> bytes) { waiting_ = bytes; }

 private:
  Codec reader_{{1, 1}};
  std::span<const std::byte> waiting_;
};

/// Uses everything that a link gives; what came from outside must be finite.
void use(Link& link, std::uint64_t step) {
  link.step(std::chrono::milliseconds(100 * step));
  const VehicleState state = link.vehicle();
  require(state.position.allFinite() && state.velocity.allFinite() && state.body_rates.allFinite());
  require(std::abs(state.attitude.norm() - 1) < 1e-3);
  while (const auto command = link.take_command()) link.answer(*command, CommandResult::kAccepted);
  while (link.take_outcome().has_value()) {
  }
  while (const auto text = link.take_text()) require(text_of(text->text).size() <= text->text.size());
  if (const auto goal = link.take_goal()) require(goal->position.allFinite() && std::isfinite(goal->yaw.value_or(0)));
  while (const auto answer = link.take_parameter()) require(std::isfinite(answer->value.value_or(0)));
  if (step == 1) link.request_mode(Mode::kOffboard);
  if (step < 4) link.request_parameter(step == 0 ? "SIXTEEN_LETTERS_" : "");
  if (step == 2) link.align({1, 2, 3}, 1);
}

constexpr std::array<std::uint32_t, 20> kIds{0,  1,  20, 21, 22,  23,  31,  32,  75,  76,
                                             77, 82, 84, 85, 111, 245, 253, 331, 436, 400};

/// A frame with a right checksum from a record of id, length, sender and payload; the bytes of the record.
std::size_t frame_of(std::span<const std::byte> record, std::array<std::byte, kMaxFrame>& frame, std::size_t& size) {
  const std::uint32_t id = kIds[static_cast<std::size_t>(record[0]) % kIds.size()];
  const std::size_t payload = std::min(static_cast<std::size_t>(record[1]), record.size() - 3);
  const bool from_autopilot = record[2] < std::byte{0xC0};
  frame[0] = std::byte{0xFD};
  frame[1] = static_cast<std::byte>(payload);
  frame[2] = frame[3] = std::byte{0};
  frame[4] = record[2];
  frame[5] = from_autopilot ? std::byte{1} : record[2];
  frame[6] = from_autopilot ? std::byte{1} : std::byte{190};
  for (std::size_t i = 0; i < 3; ++i) frame[7 + i] = static_cast<std::byte>(id >> (8 * i) & 0xFFU);
  std::copy_n(record.begin() + 3, payload, frame.begin() + 10);
  const std::uint16_t checksum = frame_checksum(std::span(frame).subspan(1, 9 + payload), layout_byte(id).value_or(0));
  frame[10 + payload] = static_cast<std::byte>(checksum & 0xFFU);
  frame[11 + payload] = static_cast<std::byte>(checksum >> 8U);
  size = 12 + payload;
  return 3 + payload;
}

}  // namespace

/// The first byte says how the rest is meant: as bytes of a line, or as records that become frames with a right
/// checksum, which a fuzzer cannot guess and an attacker computes; and whether the link has a key.
// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer calls it so
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  std::span<const std::byte> input = std::as_bytes(std::span(data, size)).subspan(1);
  std::array<Parameter, 2> parameters{Parameter{"A", 1, 0, 2, true}, Parameter{"SIXTEEN_LETTERS_", 1, 0, 2, false}};
  LinkConfig config;
  config.parameters = parameters;
  if ((data[0] & 2U) != 0) config.signing = Signing{};
  FuzzUart uart;
  Link link(uart, config);
  std::uint64_t step = 0;
  if ((data[0] & 1U) == 0) {
    uart.receive(input);
    for (int i = 0; i < 4; ++i) use(link, step++);
    return 0;
  }
  while (input.size() >= 3) {
    std::array<std::byte, kMaxFrame> frame{};
    std::size_t frame_bytes = 0;
    input = input.subspan(frame_of(input, frame, frame_bytes));
    uart.receive(std::span(frame).first(frame_bytes));
    use(link, step++);
  }
  for (const Parameter& parameter : parameters) require(parameter.value >= 0 && parameter.value <= 2);
  return 0;
}
