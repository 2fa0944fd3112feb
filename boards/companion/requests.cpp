#include "companion/requests.hpp"

namespace swiftlet::companion {
namespace {

constexpr TimeUs kAgain = kSecondUs + kSecondUs / 5;  // a HEARTBEAT may come a second late
constexpr TimeUs kAfterMode = kSecondUs / 2;          // PX4 checks anew what it can arm for
constexpr std::uint16_t kCommandNavTakeoff = 22;      // MAV_CMD_NAV_TAKEOFF

const char* name_of(std::uint16_t command) {
  if (command == mavlink::kCommandDoSetMode) return "the change of mode";
  if (command == mavlink::kCommandArmDisarm) return "arming";
  return command == kCommandNavTakeoff ? "the take-off" : "a command";
}

}  // namespace

void Requests::step(TimeUs now) {
  while (const std::optional<mavlink::Outcome> outcome = link_.take_outcome()) {
    waiting_ = false;
    const bool done = outcome->kind == mavlink::Outcome::Kind::kDone;
    const bool shows = done && outcome->command == mavlink::kCommandDoSetMode;  // the others show in a HEARTBEAT
    next_at_ = now + (shows ? kAfterMode : kAgain);
    if (done) continue;
    const bool silent = outcome->kind == mavlink::Outcome::Kind::kNoAnswer;
    Line line("the autopilot ");
    line << (silent ? "does not answer to " : "refuses ") << name_of(outcome->command);
    if (!silent) line << ", result " << static_cast<std::uint32_t>(outcome->result);
    journal_.warn(line);
  }
}

void Requests::cancel() {
  if (waiting_) link_.cancel_requests();
  waiting_ = false;
}

void Requests::asked(bool taken, TimeUs now) {
  waiting_ = taken;
  if (!taken) next_at_ = now + kAgain;
}

void Requests::ask_for_mode(mavlink::Mode mode, TimeUs now) {
  if (may_ask(now)) asked(link_.request_mode(mode), now);
}

void Requests::ask_to_arm(TimeUs now) {
  if (may_ask(now)) asked(link_.request_arm(true), now);
}

void Requests::ask_to_take_off(Real height, TimeUs now) {
  if (may_ask(now)) asked(link_.request(kCommandNavTakeoff, {0, 0, 0, 0, 0, 0, static_cast<float>(height)}), now);
}

}  // namespace swiftlet::companion
