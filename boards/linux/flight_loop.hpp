#pragma once
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "companion/companion.hpp"
#include "linux/port.hpp"

namespace swiftlet::board {

/// How late steps were, in bins of 0.1 ms.
class Lateness {
 public:
  void add(std::chrono::microseconds late);
  /// [ms] below which `share` of the steps were; to the bin's upper edge.
  [[nodiscard]] double quantile(double share) const;
  [[nodiscard]] double most() const { return static_cast<double>(most_.count()) / 1000; }  ///< [ms]
  [[nodiscard]] std::uint64_t count() const { return count_; }

 private:
  std::array<std::uint64_t, 1001> bins_{};
  std::uint64_t count_ = 0;
  std::chrono::microseconds most_{0};
};

/// What a look at the flight shows.
struct FlightView {
  companion::Telemetry telemetry;  ///< its spans must not be looked into: they are the flight's
  Lateness lateness;
  std::vector<companion::Note> notes;  ///< since the last look
};

/// Steps a companion at a steady 100 Hz in a thread of its own, and keeps its line open. Others reach it through short
/// critical sections only.
class FlightLoop {
 public:
  FlightLoop(companion::Companion& companion, Port& port);
  ~FlightLoop() { end(); }
  FlightLoop(const FlightLoop&) = delete;
  FlightLoop& operator=(const FlightLoop&) = delete;

  void tell(const companion::Word& word);
  void replace_map(const BoxGraphView& map, const std::string& file);
  FlightView look();
  void end();

  static constexpr std::chrono::microseconds kPeriod{10'000};
  /// When the step after the one of time `step` begins, at time `now`: a period later, or at once when that is past.
  /// Steps that are late by more than half a period are left out: of a burst of set-points only the last would count.
  static std::chrono::microseconds step_after(std::chrono::microseconds step, std::chrono::microseconds now);

 private:
  void run();
  void keep_port(std::chrono::microseconds now);
  void take_words();
  void show(const companion::Note& note);
  void warn(std::string_view text);
  void publish(std::chrono::microseconds late);

  companion::Companion& companion_;
  Port& port_;
  std::mutex mutex_;
  std::vector<companion::Word> words_;
  std::optional<BoxGraphView> map_;
  std::string map_file_;
  FlightView view_;
  std::uint32_t noted_ = 0;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace swiftlet::board
