#include "companion/flight_log.hpp"

#include <algorithm>

#include "swiftlet/mavlink/frames.hpp"

namespace swiftlet::companion {
namespace {

constexpr TimeUs kStatusInterval = 100'000;

/// zlib's CRC-32 of `bytes` after those that gave `crc`; 0 begins. Four bits at a time: a table of 64 bytes.
std::uint32_t crc32(std::uint32_t crc, std::span<const std::byte> bytes) {
  constexpr std::array<std::uint32_t, 16> kTable{0x00000000, 0x1DB71064, 0x3B6E20C8, 0x26D930AC, 0x76DC4190, 0x6B6B51F4,
                                                 0x4DB26158, 0x5005713C, 0xEDB88320, 0xF00F9344, 0xD6D6A3E8, 0xCB61B38C,
                                                 0x9B64C2B0, 0x86D3D2D4, 0xA00AE278, 0xBDBDF21C};
  crc = ~crc;
  for (const std::byte byte : bytes) {
    crc ^= std::to_integer<std::uint32_t>(byte);
    crc = (crc >> 4U) ^ kTable[crc & 0xFU];
    crc = (crc >> 4U) ^ kTable[crc & 0xFU];
  }
  return ~crc;
}

std::array<float, 3> floats(const Vector3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

std::array<float, 3> ned_floats(const Vector3& v_W) { return floats(mavlink::to_ned(v_W).value); }

std::array<float, 4> ned_floats(const Quaternion& q_WB) {
  const mavlink::Quaternion q = mavlink::to_ned(mavlink::Quaternion(q_WB.w(), q_WB.x(), q_WB.y(), q_WB.z())).value;
  return {static_cast<float>(q.w()), static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z())};
}

std::uint64_t stamp(TimeUs time) { return static_cast<std::uint64_t>(time); }

/// Microseconds in 32 bits; longer ones are cut.
std::int32_t short_time(TimeUs time) {
  constexpr TimeUs kLongest = 2'000'000'000;
  return static_cast<std::int32_t>(std::clamp(time, -kLongest, kLongest));
}

template <typename... Topics>
void define(UlogWriter& writer) {
  (writer.format(Topics::kFormat), ...);
}

template <typename... Topics>
void subscribe(UlogWriter& writer) {
  (writer.subscribe(Topics::kId, topic::kName<Topics>), ...);
}

}  // namespace

bool FlightLog::begin(std::string_view name, TimeUs now, const LogHeader& header) {
  using namespace topic;  // NOLINT(google-build-using-namespace): the list below
  (void)writer_.begin(name, now);
  define<VehicleLocalPosition, VehicleAttitude, VehicleAngularVelocity, TrajectorySetpoint, VehicleAttitudeSetpoint,
         VehicleRatesSetpoint, Status, topic::Plan, PlanSegment, Input>(writer_);
  writer_.info("sys_name", "swiftlet");
  writer_.info("ver_sw", header.version);
  writer_.info("ver_hw", header.board);
  writer_.info("swiftlet_map_crc32", header.map_crc32);
  name_map(header.map_crc32, header.map_file);
  writer_.info("swiftlet_real_bytes", static_cast<std::uint32_t>(sizeof(Real)));
  writer_.info("swiftlet_signed", header.is_signed ? 1U : 0U);
  writer_.info("swiftlet_settings", header.settings);
  subscribe<VehicleLocalPosition, VehicleAttitude, VehicleAngularVelocity, TrajectorySetpoint, VehicleAttitudeSetpoint,
            VehicleRatesSetpoint, Status, topic::Plan, PlanSegment, Input>(writer_);
  writer_.flush();
  now_ = now;
  return !writer_.full();
}

void FlightLog::end() {
  finish_piece();  // even an empty one: it says that the log is whole
  writer_.flush();
}

void FlightLog::begin_step(TimeUs now) {
  now_ = now;
  empty_reads_ = 0;
  put(InputKind::kStep);
  put(now);
}

void FlightLog::note_read(std::span<const std::byte> bytes) {
  if (bytes.empty()) {
    ++empty_reads_;
    return;
  }
  for (; empty_reads_ > 0; --empty_reads_) {
    put(InputKind::kRead);
    put(std::uint16_t{0});
  }
  constexpr std::size_t kLongestRead = 0xFFFF;  // the link reads 512 at a time
  put(InputKind::kRead);
  put(static_cast<std::uint16_t>(std::min(bytes.size(), kLongestRead)));
  put(bytes.first(std::min(bytes.size(), kLongestRead)));
}

void FlightLog::note_write(std::span<const std::byte> offered, std::size_t taken) {
  if (taken != offered.size()) {
    put(InputKind::kWrite);
    put(writes_);
    put(static_cast<std::uint16_t>(taken));
  }
  sent_crc_ = crc32(sent_crc_, offered);
  ++writes_;
}

void FlightLog::note_plan_done() { put(InputKind::kPlanDone); }

void FlightLog::note_word(const Word& word) {
  put(InputKind::kWord);
  put(word.kind);
  put(word.id);
  for (const Real x : word.a) put(static_cast<double>(x));
  for (const Real x : word.b) put(static_cast<double>(x));
  put(static_cast<std::uint8_t>(word.yaw.has_value()));
  put(static_cast<double>(word.yaw.value_or(Real(0))));
}

void FlightLog::note_map(std::uint32_t crc32, std::string_view file) {
  name_map(crc32, file);
  put(InputKind::kMap);
  put(crc32);
}

void FlightLog::name_map(std::uint32_t crc32, std::string_view file) {
  if (file.empty()) return;
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::array<char, kMapFileKey.size() + 8> key{};
  auto at = std::copy(kMapFileKey.begin(), kMapFileKey.end(), key.begin());
  for (unsigned shift = 32; shift > 0; *at++ = kDigits[(crc32 >> shift) & 0xFU]) shift -= 4;
  writer_.info({key.data(), key.size()}, file);
}

void FlightLog::write(const FlightEvent& event) {
  std::array<char, 120> line{};
  std::size_t size = 0;
  const auto append = [&](std::string_view text) {
    text = {text.data(), std::min(text.size(), line.size() - size)};
    std::copy(text.begin(), text.end(), line.begin() + static_cast<std::ptrdiff_t>(size));
    size += text.size();
  };
  if (event.from != event.to) {
    append(describe(event.from));
    append(" -> ");
  }
  append(describe(event.to));
  append(": ");
  append(describe(event.reason));
  constexpr std::uint8_t kWarning = 4;
  constexpr std::uint8_t kInfo = 6;
  writer_.text(event.time, event.reason >= Reason::kLinkLost ? kWarning : kInfo, {line.data(), size});
}

void FlightLog::write(const Note& note) {
  writer_.text(note.time, static_cast<std::uint8_t>(note.severity), note.view());
}

void FlightLog::end_step(const Telemetry& telemetry) {
  write_estimate(telemetry);
  write_setpoint(telemetry);
  if (telemetry.plan.id != plan_) write_plan(telemetry);
  if (status_is_due(telemetry)) write_status(telemetry);
  put(InputKind::kSent);
  put(writes_);
  put(sent_crc_);
  writes_ = 0;
  sent_crc_ = 0;
  writer_.flush();
}

void FlightLog::write_estimate(const Telemetry& telemetry) {
  const VehicleState& estimate = telemetry.estimate;
  if (!telemetry.has_estimate || estimate.time == estimate_time_) return;
  estimate_time_ = estimate.time;
  const std::uint64_t now = stamp(telemetry.time);
  const std::uint64_t sampled = stamp(estimate.time);
  const auto heading = static_cast<float>(mavlink::ned_yaw(mavlink::yaw_of(estimate.attitude)));
  write_topic(topic::VehicleLocalPosition{
      now, sampled, ned_floats(estimate.position), ned_floats(estimate.velocity), heading, {true, true, true, true}});
  write_topic(topic::VehicleAttitude{now, sampled, ned_floats(estimate.attitude)});
  write_topic(topic::VehicleAngularVelocity{now, sampled, floats(mavlink::to_frd(estimate.body_rates).value)});
}

void FlightLog::write_setpoint(const Telemetry& telemetry) {
  if (!telemetry.sent) return;
  const std::uint64_t now = stamp(telemetry.time);
  if (telemetry.has_reference) {
    const Reference& reference = telemetry.reference;
    write_topic(topic::TrajectorySetpoint{
        now, ned_floats(reference.sample.position), ned_floats(reference.sample.velocity),
        ned_floats(reference.sample.acceleration), ned_floats(reference.sample.jerk),
        static_cast<float>(mavlink::ned_yaw(reference.yaw)), static_cast<float>(-reference.yaw_rate)});
  }
  const std::array<float, 3> thrust{0, 0, static_cast<float>(-telemetry.thrust)};
  const TrackingCommand& command = telemetry.command;
  if (telemetry.form == SetpointForm::kAttitude) {
    write_topic(topic::VehicleAttitudeSetpoint{now, static_cast<float>(-command.yaw_rate), ned_floats(command.attitude),
                                               thrust});
  } else if (telemetry.form == SetpointForm::kRates) {
    write_topic(topic::VehicleRatesSetpoint{now, floats(mavlink::to_frd(command.body_rates).value), thrust});
  }
}

bool FlightLog::status_is_due(const Telemetry& telemetry) const {
  const TimeUs age = telemetry.time - static_cast<TimeUs>(status_.timestamp);
  return age >= kStatusInterval || age <= 0 || static_cast<std::uint8_t>(telemetry.state) != status_.state ||
         static_cast<std::uint8_t>(telemetry.reason) != status_.reason ||
         static_cast<std::uint8_t>(telemetry.phase) != status_.phase;
}

void FlightLog::write_status(const Telemetry& telemetry) {
  status_.timestamp = stamp(telemetry.time);
  status_.received_bytes = telemetry.link.received_bytes;
  status_.sent_bytes = telemetry.link.sent_bytes;
  status_.estimate_age = telemetry.has_estimate ? short_time(telemetry.time - telemetry.estimate.time) : -1;
  status_.link_delay = short_time(telemetry.link_delay);
  status_.plan_latency = short_time(telemetry.plan.latency);
  status_.plan = telemetry.plan.id;
  status_.tracking_error = static_cast<float>(telemetry.tracking_error);
  status_.thrust = static_cast<float>(telemetry.thrust);
  status_.hover_thrust = static_cast<float>(telemetry.hover_thrust);
  status_.goals_reached = telemetry.goals_reached;
  status_.goals_waiting = telemetry.goals_waiting;
  status_.plans_discarded = telemetry.plans_discarded;
  status_.deadline_misses = telemetry.deadline_misses;
  status_.lost_frames = telemetry.link.lost_frames;
  status_.bad_checksums = telemetry.codec.bad_checksum;
  status_.unsent_frames = telemetry.link.unsent_frames;
  status_.state = static_cast<std::uint8_t>(telemetry.state);
  status_.reason = static_cast<std::uint8_t>(telemetry.reason);
  status_.phase = static_cast<std::uint8_t>(telemetry.phase);
  status_.form = static_cast<std::uint8_t>(telemetry.form);
  status_.setpoints = static_cast<std::uint8_t>(telemetry.setpoints);
  status_.mode = static_cast<std::uint8_t>(telemetry.mode);
  status_.armed = telemetry.armed;
  status_.aligned = telemetry.aligned;
  write_topic(status_);
}

void FlightLog::write_plan(const Telemetry& telemetry) {
  const CommittedPlan& plan = telemetry.plan;
  plan_ = plan.id;
  const std::uint64_t now = stamp(telemetry.time);
  const auto count = static_cast<std::uint32_t>(plan.segments.size());
  write_topic(topic::Plan{now, stamp(plan.start), plan.id, count, static_cast<float>(total_duration(plan.segments)),
                          short_time(plan.latency), floats(plan.from.position), floats(plan.goal.position),
                          static_cast<float>(plan.certificate.box_margin), plan.map_crc,
                          static_cast<std::uint32_t>(plan.status)});
  for (std::uint32_t i = 0; i < count && i < plan.boxes.size(); ++i) {
    write_topic(topic::PlanSegment{now, plan.id, i, static_cast<float>(plan.segments[i].duration),
                                   floats(plan.boxes[i].lo), floats(plan.boxes[i].hi)});
  }
}

void FlightLog::put(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t count = std::min(bytes.size(), piece_.bytes.size() - piece_size_);
    std::copy_n(bytes.begin(), count, piece_.bytes.begin() + static_cast<std::ptrdiff_t>(piece_size_));
    piece_size_ += count;
    bytes = bytes.subspan(count);
    if (piece_size_ == piece_.bytes.size()) finish_piece();
  }
}

void FlightLog::finish_piece() {
  std::fill(piece_.bytes.begin() + static_cast<std::ptrdiff_t>(piece_size_), piece_.bytes.end(), std::byte{0});
  piece_.timestamp = stamp(now_);
  write_topic(piece_);
  piece_size_ = 0;
}

}  // namespace swiftlet::companion
