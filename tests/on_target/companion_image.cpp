// The flight of the image `companion` in lock-step with companion_peer at the other end of the autopilot's line: the
// same sources, but for where the time comes from.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <string_view>

#include "bare/flight.hpp"
#include "board.hpp"
#include "companion/note_printer.hpp"
#include "lockstep.hpp"

namespace {

using std::chrono::microseconds;
using std::chrono::nanoseconds;
using swiftlet::Real;
using swiftlet::companion::Line;
using swiftlet::companion::Telemetry;

/// The autopilot's line, on which time comes too. Between two steps nothing reaches the companion.
class LockstepLine final : public swiftlet::hal::Uart {
 public:
  explicit LockstepLine(swiftlet::hal::Uart& line) : line_(line) {}

  std::size_t write(std::span<const std::byte> bytes) override { return line_.write(bytes); }
  std::size_t read(std::span<std::byte> into) override {
    const std::size_t count = std::min(into.size(), filled_ - taken_);
    std::copy_n(received_.begin() + static_cast<std::ptrdiff_t>(taken_), count, into.begin());
    taken_ += count;
    return count;
  }
  [[nodiscard]] std::uint32_t overruns() const override { return line_.overruns() + overflows_; }

  /// The peer's time of the next step; nothing when the flight is over.
  std::optional<microseconds> next_step() {
    if (taken_ != filled_) ++overflows_;  // the companion did not keep up
    filled_ = taken_ = 0;
    ask();
    std::optional<microseconds> answer;
    while (!answer) answer = wait_for_answer();
    if (*answer < microseconds(0)) return std::nullopt;
    return now_ = *answer;
  }

 private:
  void ask() {
    const std::int64_t now = std::chrono::duration_cast<nanoseconds>(now_).count();
    std::span<const std::byte> frame = codec_.encode(swiftlet::mavlink::TimeSyncMessage{.tc1 = 0, .ts1 = now});
    while (!frame.empty()) frame = frame.subspan(line_.write(frame));
  }

  /// Keeps what came; an answer that ends the flight when nothing can come any more.
  std::optional<microseconds> wait_for_answer() {
    const std::span<std::byte> room = std::span(received_).subspan(filled_);
    const std::size_t count = swiftlet::lockstep::wait_for_bytes(room);
    filled_ += count;
    if (count == 0) ++overflows_;
    return count == 0 ? microseconds(-1) : look_for_answer(room.first(count));
  }

  std::optional<microseconds> look_for_answer(std::span<const std::byte> bytes) {
    while (const auto frame = codec_.receive(bytes)) {
      if (frame->from != swiftlet::lockstep::kPeer) continue;
      const auto answer = swiftlet::mavlink::decode<swiftlet::mavlink::TimeSyncMessage>(*frame);
      if (answer) return std::chrono::floor<microseconds>(nanoseconds(answer->tc1));
    }
    return std::nullopt;
  }

  swiftlet::hal::Uart& line_;
  swiftlet::mavlink::Codec codec_{swiftlet::lockstep::kImage};
  microseconds now_{0};
  std::array<std::byte, 8192> received_{};
  std::size_t filled_ = 0;
  std::size_t taken_ = 0;
  std::uint32_t overflows_ = 0;
};

/// Of the estimate to the reference, while goals are flown to.
struct TrackingMeter {
  Real squares = 0;
  Real most = 0;
  std::uint32_t count = 0;

  void add(const Telemetry& telemetry) {
    if (telemetry.phase != swiftlet::companion::Phase::kMission) return;
    squares += telemetry.tracking_error * telemetry.tracking_error;
    most = std::max(most, telemetry.tracking_error);
    ++count;
  }
  [[nodiscard]] Real rms() const { return count == 0 ? 0 : std::sqrt(squares / static_cast<Real>(count)); }
};

void print(const Line& line) {
  swiftlet::board::console().write(line.view());
  swiftlet::board::console().write({"\n", 1});
}

}  // namespace

/// Usage: companion_image [MAP], a bare board's lies in its map region. 0 when the line lost nothing and every
/// set-point was accepted by it.
int main(int argc, char** argv) {
  static LockstepLine line(swiftlet::lockstep::line());
  swiftlet::companion::Companion* const companion =
      swiftlet::board::begin_flight(line, swiftlet::lockstep::storage(), argc > 1 ? argv[1] : "");
  if (companion == nullptr) return 3;
  TrackingMeter tracking;
  swiftlet::companion::NotePrinter printer(swiftlet::board::console());
  while (const std::optional<microseconds> now = line.next_step()) {
    companion->step(*now);
    (void)printer.print_next(companion->journal());
    tracking.add(companion->telemetry());
  }
  while (printer.print_next(companion->journal())) {
  }
  const Telemetry& t = companion->telemetry();
  print(Line("goals reached ") << t.goals_reached << ", plans " << t.plan.id << ", discarded " << t.plans_discarded);
  print(Line("tracking ") << tracking.rms() * 100 << " cm RMS, " << tracking.most * 100 << " cm at most");
  print(Line("overruns ") << line.overruns() << ", unsent " << t.link.unsent_frames << ", lost " << t.link.lost_frames
                          << ", damaged " << t.codec.bad_checksum);
  print(Line("stack ") << static_cast<std::uint32_t>(swiftlet::board::stack_bytes_used()) << " bytes");
  if (!swiftlet::lockstep::hand_out(swiftlet::board::end_log())) return 4;
  return line.overruns() + t.link.unsent_frames + t.link.lost_frames + t.codec.bad_checksum == 0 ? 0 : 1;
}
