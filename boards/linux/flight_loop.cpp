#include "linux/flight_loop.hpp"

#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "swiftlet/hal/monotonic_clock.hpp"

namespace swiftlet::board {
namespace {

using std::chrono::microseconds;

constexpr microseconds kBin{100};
constexpr int kPriority = 20;
constexpr std::size_t kMostNotes = 256;  // unread

/// Sleeps on the clock that MonotonicClock reads.
void sleep_until(microseconds time) {
  timespec until{};
  until.tv_sec = static_cast<time_t>(time.count() / 1'000'000);
  until.tv_nsec = static_cast<long>(time.count() % 1'000'000 * 1000);
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace

void Lateness::add(microseconds late) {
  const auto bin = static_cast<std::size_t>(std::max<std::int64_t>(late / kBin, 0));
  ++bins_[std::min(bin, bins_.size() - 1)];
  ++count_;
  most_ = std::max(most_, late);
}

double Lateness::quantile(double share) const {
  std::uint64_t below = 0;
  std::size_t bin = 0;
  while (bin < bins_.size() && static_cast<double>(below) < share * static_cast<double>(count_)) below += bins_[bin++];
  return static_cast<double>(bin) * static_cast<double>(kBin.count()) / 1000;
}

FlightLoop::FlightLoop(companion::Companion& companion, Port& port) : companion_(companion), port_(port) {
  view_.notes.reserve(kMostNotes);
  thread_ = std::thread([this] { run(); });
  const sched_param priority{kPriority};
  (void)::pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority);  // where it is allowed
}

void FlightLoop::end() {
  ends_ = true;
  if (thread_.joinable()) thread_.join();
}

void FlightLoop::tell(const companion::Word& word) {
  const std::lock_guard lock(mutex_);
  words_.push_back(word);
}

void FlightLoop::replace_map(const BoxGraphView& map, const std::string& file) {
  const std::lock_guard lock(mutex_);
  map_ = map;
  map_file_ = file;
}

FlightView FlightLoop::look() {
  const std::lock_guard lock(mutex_);
  FlightView seen = view_;
  view_.notes.clear();
  return seen;
}

/// Under the lock.
void FlightLoop::show(const companion::Note& note) {
  if (view_.notes.size() < kMostNotes) view_.notes.push_back(note);
}

void FlightLoop::warn(std::string_view text) {
  companion::Note note{companion_.telemetry().time, mavlink::Severity::kWarning, {}};
  std::copy(text.begin(), text.end(), note.text.begin());
  show(note);
}

void FlightLoop::keep_port(microseconds now) {
  const Port::Change change = port_.keep(now);
  if (change == Port::Change::kNone) return;
  const std::lock_guard lock(mutex_);
  warn(change == Port::Change::kGone ? "the port has gone; trying to open it again" : "the port is open again");
}

void FlightLoop::take_words() {
  const std::lock_guard lock(mutex_);
  std::size_t taken = 0;
  while (taken < words_.size() && taken < companion::Companion::kMostWords) {
    if (!companion_.tell(words_[taken])) warn("refused: numbers out of range");
    ++taken;
  }
  words_.erase(words_.begin(), words_.begin() + static_cast<std::ptrdiff_t>(taken));
  if (map_) (void)companion_.replace_map(*map_, map_file_);  // its journal says why not
  map_.reset();
}

void FlightLoop::publish(microseconds late) {
  const std::lock_guard lock(mutex_);
  view_.telemetry = companion_.telemetry();
  view_.lateness.add(late);
  for (; noted_ != companion_.note_count(); ++noted_) show(companion_.note(noted_));
}

microseconds FlightLoop::step_after(microseconds step, microseconds now) {
  step += kPeriod;
  if (now > step) step += (now - step + kPeriod / 2 - microseconds(1)) / kPeriod * kPeriod;
  return step;
}

void FlightLoop::run() {
  hal::MonotonicClock clock;
  microseconds due = clock.now();
  microseconds next = due;
  while (!ends_) {
    sleep_until(next);
    take_words();
    const microseconds now = clock.now();
    keep_port(now);
    companion_.step(now);
    publish(now - due);
    due = next + kPeriod;
    next = step_after(next, clock.now());
  }
}

}  // namespace swiftlet::board
