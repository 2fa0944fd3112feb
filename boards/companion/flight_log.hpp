#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "companion/log_topics.hpp"
#include "companion/telemetry.hpp"
#include "companion/ulog_writer.hpp"
#include "companion/word.hpp"
#include "swiftlet/hal/uart.hpp"

namespace swiftlet::companion {

/// What a flight can be replayed with, beside its inputs. Texts outlive begin() only.
struct LogHeader {
  std::string_view version;   ///< kVersion
  std::string_view board;     ///< for people
  std::string_view settings;  ///< all of the companion's settings as a swiftlet-config/1 text
  std::uint32_t map_crc32 = 0;
  std::string_view map_file{};  ///< where a replay finds that map; empty: nowhere
  bool is_signed = false;       ///< whether messages are signed; the key is not kept
};

/// A map's file is information under this key and the map's CRC-32, eight hexadecimal digits.
inline constexpr std::string_view kMapFileKey = "swiftlet_map_file_";

/// Records in the stream of inputs; fields follow the kind, little-endian, real numbers as doubles. Words, maps and
/// writes that come between two steps lie between their records.
enum class InputKind : std::uint8_t {
  kEnd = 0,       ///< the rest of this piece is empty
  kStep = 1,      ///< i64 now [us]; what follows belongs to this step
  kRead = 2,      ///< u16 n, n bytes: what one Uart::read gave; reads that gave nothing at a step's end are left out
  kWrite = 3,     ///< u16 k, u16 n: of the k-th write since the last kSent the device took but n bytes
  kPlanDone = 4,  ///< PlanWorker::done was true; at most twice in a step
  kWord = 5,      ///< u8 kind, u32 id, 3 f64 a, 3 f64 b, u8 has_yaw, f64 yaw: a word of the operator
  kMap = 6,       ///< u32 CRC-32: another map was given
  kSent = 7,      ///< ends a step: u16 writes, u32 CRC-32 of all bytes offered to the device since the last one
};

/// The log of a flight: what PX4's tools plot, what people read, and every input, so that the flight can be replayed
/// bit for bit. An append of at most a few hundred bytes a step; when the storage refuses, the log is full, the flight
/// goes on and nothing more is kept. docs/flight.md, "The log and its replay".
class FlightLog {
 public:
  explicit FlightLog(hal::Storage& storage) : writer_(storage) {}

  /// Begins the log `name`, which must not exist yet, before the companion is made. `name` outlives the log.
  /// False, and full(), when the storage refuses.
  bool begin(std::string_view name, TimeUs now, const LogHeader& header);

  /// The storage refused, or the log was never begun.
  [[nodiscard]] bool full() const { return writer_.full(); }
  [[nodiscard]] std::uint64_t bytes() const { return writer_.bytes(); }

  /// Writes what still waits; after the last step.
  void end();

  // For the companion: everything that enters, in the order in which it does.
  void begin_step(TimeUs now);
  void note_read(std::span<const std::byte> bytes);
  void note_write(std::span<const std::byte> offered, std::size_t taken);
  void note_plan_done();
  void note_word(const Word& word);                           ///< whether it is accepted or not
  void note_map(std::uint32_t crc32, std::string_view file);  ///< as LogHeader::map_file

  // For the companion: what it says. At the end of a step, before end_step.
  void write(const FlightEvent& event);
  void write(const Note& note);
  void end_step(const Telemetry& telemetry);

 private:
  template <typename Topic>
  void write_topic(const Topic& message) {
    writer_.data(Topic::kId, std::as_bytes(std::span(&message, 1)).first(ulog_format_size(Topic::kFormat)));
  }
  void name_map(std::uint32_t crc32, std::string_view file);
  void write_estimate(const Telemetry& telemetry);
  void write_setpoint(const Telemetry& telemetry);
  void write_status(const Telemetry& telemetry);
  void write_plan(const Telemetry& telemetry);
  [[nodiscard]] bool status_is_due(const Telemetry& telemetry) const;

  void put(std::span<const std::byte> bytes);
  template <typename Number>
  void put(Number number) {
    put(std::as_bytes(std::span(&number, 1)));
  }
  void finish_piece();

  UlogWriter writer_;
  topic::Input piece_;
  std::size_t piece_size_ = 0;

  TimeUs now_ = 0;
  std::uint32_t empty_reads_ = 0;  // not recorded yet
  std::uint16_t writes_ = 0;       // since the last step's end
  std::uint32_t sent_crc_ = 0;

  TimeUs estimate_time_ = -1;  // of the last that was written
  std::uint32_t plan_ = 0;
  topic::Status status_;
};

/// A device whose traffic is noted in a log, when there is one.
class RecordedUart final : public hal::Uart {
 public:
  RecordedUart(hal::Uart& uart, FlightLog* log) : uart_(uart), log_(log) {}

  std::size_t write(std::span<const std::byte> bytes) override {
    const std::size_t taken = uart_.write(bytes);
    if (log_ != nullptr) log_->note_write(bytes, taken);
    return taken;
  }
  std::size_t read(std::span<std::byte> into) override {
    const std::size_t count = uart_.read(into);
    if (log_ != nullptr) log_->note_read(into.first(count));
    return count;
  }
  [[nodiscard]] std::uint32_t overruns() const override { return 0; }  ///< Not recorded, so nobody may rest on it.

 private:
  hal::Uart& uart_;
  FlightLog* log_;
};

}  // namespace swiftlet::companion
